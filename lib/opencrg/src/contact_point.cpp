#include "contact_point.h"

#include <array>
#include <atomic>
#include <cmath>
#include <memory>

namespace opencrg {
namespace {

// Ids are places in a table that grows by blocks which never move: looking one up needs no lock
// while others are made.
constexpr int kBlock = 64, kBlocks = 16384;
using Block = std::array<std::atomic<ContactPoint*>, kBlock>;
std::array<std::atomic<Block*>, kBlocks> table = {};

template <typename Work>
void for_all(const Work& work) {
  for (int b = 0; b < kBlocks; ++b) {
    if (table[b] == nullptr) return;
    for (int k = 0; k < kBlock; ++k)
      if (ContactPoint* point = (*table[b].load())[k]) work(b * kBlock + k, *point);
  }
}

}  // namespace

ContactPoint* find_contact_point(int id) noexcept {
  if (id < 0 || id >= kBlock * kBlocks) return nullptr;
  const Block* block = table[id / kBlock].load(std::memory_order_acquire);
  return block == nullptr ? nullptr : (*block)[id % kBlock].load(std::memory_order_acquire);
}

int create_contact_point(DataSet& set) {
  auto point = std::make_unique<ContactPoint>();
  point->set = &set;
  point->options = set.options;
  refresh(*point);
  for (int b = 0; b < kBlocks; ++b) {
    if (table[b] == nullptr) table[b] = new Block{};
    for (int k = 0; k < kBlock; ++k) {
      std::atomic<ContactPoint*>& place = (*table[b].load())[k];
      if (place != nullptr) continue;
      place = point.release();
      return b * kBlock + k;
    }
  }
  return -1;
}

bool delete_contact_point(int id) {
  const std::unique_ptr<ContactPoint> point(find_contact_point(id));
  if (!point) return false;
  (*table[id / kBlock].load())[id % kBlock] = nullptr;
  return true;
}

void delete_contact_points(const DataSet* set) {
  for_all([&](int id, const ContactPoint& point) {
    if (set == nullptr || point.set == set) delete_contact_point(id);
  });
}

void refresh(ContactPoint& point) {
  const auto is = [&](unsigned int id, int wanted) {
    int value = 0;
    return point.options.get_int(id, value) && value == wanted;
  };
  const bool close = is(dCrgCpOptionRefLineContinue, dCrgRefLineCloseTrack);
  point.surface = &surface_of(*point.set, close);
  point.closed = close ? point.set->range : ClosedRange{};
  point.border = border_of(point.options);
  point.smooth = point.border.smooth();
  point.line_curvature = is(dCrgCpOptionCurvMode, dCrgCurvRefLine);
}

void refresh_points_of(const DataSet& set) {
  for_all([&](int, ContactPoint& point) {
    if (point.set == &set) refresh(point);
  });
}

void search_from(ContactPoint& point, double u_m) {
  const crg::Grid& grid = point.surface->grid();
  const double rows = (u_m - grid.u_begin_m) / grid.u_step_m;
  if (!(rows >= 0.0 && rows <= static_cast<double>(grid.rows() - 2))) return;
  point.cursor = {rows, 0.0};
}

}  // namespace opencrg
