#include "support/oval_road.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace test_support {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

double kerb_height(double u, double v, const OvalOptions& options, double begin_m) {
  const double along = std::min(u - begin_m - 20.0, begin_m + 60.0 - u);
  const double across = std::abs(v) - 6.0;
  if (along <= 0.0 || across <= 0.0 || across >= 1.0) return 0.0;
  // Rises over 0.6 m, falls over 0.4 m.
  const double profile = across < 0.6 ? across / 0.6 : (1.0 - across) / 0.4;
  return options.kerb_height_m * profile * std::min(1.0, along / 2.0);
}

struct Wave {
  double amplitude_m, k_u, k_v, phase;
  std::complex<double> turn;  ///< of its phase from one column to the next
};

/// Adds the heights of the waves along a row, one after the other. Eight turn at a time: one alone
/// waits for its own last product.
void add_waves(const std::vector<Wave>& waves, double u_m, double v_begin_m,
               std::vector<double>& row) {
  constexpr std::size_t kAtOnce = 8;
  for (std::size_t begin = 0; begin < waves.size(); begin += kAtOnce) {
    std::array<double, kAtOnce> re{}, im{}, cosine{}, sine{};
    for (std::size_t k = 0; k < std::min(kAtOnce, waves.size() - begin); ++k) {
      const Wave& wave = waves[begin + k];
      const auto phasor =
          std::polar(wave.amplitude_m, wave.k_u * u_m + wave.k_v * v_begin_m + wave.phase);
      re[k] = phasor.real(), im[k] = phasor.imag();
      cosine[k] = wave.turn.real(), sine[k] = wave.turn.imag();
    }
    for (double& z : row) {
      for (const double part : re) z += part;
      for (std::size_t k = 0; k < kAtOnce; ++k) {
        const double turned = re[k] * cosine[k] - im[k] * sine[k];
        im[k] = re[k] * sine[k] + im[k] * cosine[k];
        re[k] = turned;
      }
    }
  }
}

}  // namespace

Oval oval_road(const OvalOptions& options) {
  const double arc_m = std::numbers::pi * options.radius_m,
               length_m = 2.0 * (options.straight_m + arc_m);
  const auto steps = static_cast<std::size_t>(std::lround(length_m / options.u_step_m));
  Oval oval;
  oval.line.u_step_m = length_m / static_cast<double>(steps);
  oval.line.closed = true;
  for (std::size_t i = 0; i <= steps; ++i) {
    // Chords of the exact curve: nodes lie on it, the heading is that of the chord.
    const double u = std::min(length_m, static_cast<double>(i) * oval.line.u_step_m);
    const double half = options.straight_m + arc_m;
    const bool second = u >= half && i < steps;
    const double s = i == steps ? 0.0 : second ? u - half : u;
    double x = std::min(s, options.straight_m), y = -options.radius_m;
    if (s > options.straight_m) {
      const double angle = (s - options.straight_m) / options.radius_m;
      x = options.straight_m + options.radius_m * std::sin(angle);
      y = -options.radius_m * std::cos(angle);
    }
    x -= 0.5 * options.straight_m;
    oval.line.x_m.push_back(second ? -x : x);
    oval.line.y_m.push_back(second ? -y : y);
  }
  oval.line.heading_rad.resize(steps + 1);
  for (std::size_t i = 1; i <= steps; ++i) {
    oval.line.heading_rad[i] = std::atan2(oval.line.y_m[i] - oval.line.y_m[i - 1],
                                          oval.line.x_m[i] - oval.line.x_m[i - 1]);
  }
  oval.line.heading_rad[0] = oval.line.heading_rad[1];

  oval.grid.u_step_m = oval.line.u_step_m;
  const int half_columns = static_cast<int>(std::lround(options.half_width_m / options.v_step_m));
  for (int j = -half_columns; j <= half_columns; ++j) oval.grid.v_m.push_back(j * options.v_step_m);
  const std::size_t columns = oval.grid.v_m.size();

  // Waves with a whole number of periods round the oval; each carries the variance of its band.
  std::vector<Wave> waves;
  std::mt19937_64 random(options.seed);
  if (options.iso_class != 0) {
    const double psd_n0 = 16e-6 * std::pow(4.0, options.iso_class - 'A');
    constexpr int kWaves = 160;
    for (int k = 0; k < kWaves; ++k) {
      const double low = 0.02 * std::pow(100.0, static_cast<double>(k) / kWaves),
                   high = low * std::pow(100.0, 1.0 / kWaves);
      const double n =
          std::max(1.0, std::round((low + (high - low) * uniform(random)) * length_m)) / length_m;
      waves.push_back({std::sqrt(2.0 * psd_n0 * std::pow(n / 0.1, -2.0) * (high - low)), kTurn * n,
                       kTurn * n * (2.0 * uniform(random) - 1.0), kTurn * uniform(random), 1.0});
      waves.back().turn = std::polar(1.0, waves.back().k_v * options.v_step_m);
    }
  }
  std::vector<double> row(columns);
  oval.grid.z_m.resize((steps + 1) * columns);
  for (std::size_t i = 0; i <= steps; ++i) {
    const double u = i == steps ? 0.0 : static_cast<double>(i) * oval.line.u_step_m;
    const double hill =
        4.0 * std::sin(kTurn * u / length_m) + 1.5 * std::cos(2.0 * kTurn * u / length_m);
    const double half = options.straight_m + arc_m;
    const double s = std::fmod(u, half);
    // Banking 4 % into the bends; rises and falls over 40 m inside them.
    const double banking =
        -0.04 * smooth_step((s - options.straight_m) / 40.0) * smooth_step((half - s) / 40.0);
    std::fill(row.begin(), row.end(), hill);
    add_waves(waves, u, oval.grid.v_m[0], row);
    for (std::size_t j = 0; j < columns; ++j) {
      const double v = oval.grid.v_m[j];
      row[j] += banking * v - 0.03 * std::max(0.0, std::abs(v) - 7.0) +
                kerb_height(u, v, options, options.straight_m) +
                kerb_height(u, v, options, half + options.straight_m);
      oval.grid.z_m[i * columns + j] = static_cast<float>(row[j]);
    }
  }
  return oval;
}

void plant(Oval& oval, const std::function<double(double u_m, double v_m)>& height) {
  for (std::size_t i = 0; i < oval.grid.rows(); ++i) {
    for (std::size_t j = 0; j < oval.grid.columns(); ++j) {
      oval.grid.at(i, j) += static_cast<float>(height(oval.grid.u_of(i), oval.grid.v_m[j]));
    }
  }
}

road::Mesh mesh_of(const Oval& oval, std::size_t stride) {
  road::Mesh mesh;
  const std::size_t columns = (oval.grid.columns() - 1) / stride + 1;
  const std::size_t rows = (oval.grid.rows() - 1) / stride;
  for (std::size_t i = 0; i <= rows; ++i) {
    const std::size_t row = i == rows ? 0 : i * stride;
    for (std::size_t j = 0; j < columns; ++j) {
      const crg::Point2 p = crg::node_position(oval.line, row, oval.grid.v_m[j * stride]);
      mesh.vertices_m.emplace_back(p.x_m, p.y_m, oval.grid.at(row, j * stride));
    }
  }
  const auto id = [&](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(i * columns + j);
  };
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j + 1 < columns; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      mesh.triangles.push_back({id(i, j + 1), id(i + 1, j), id(i + 1, j + 1)});
    }
  }
  mesh.objects.emplace_back();
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  return mesh;
}

}  // namespace test_support
