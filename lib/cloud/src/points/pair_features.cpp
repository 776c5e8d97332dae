// The one function of PCL's library of features that is no template: with it here the library,
// whose loading takes longer than most commands, is not loaded.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace pcl {
// NOLINTBEGIN(readability-identifier-naming): PCL's name

/// How two points and their normals lie to each other, in the frame (u, v, w) that the first of
/// them spans (Rusu, Blodow, Beetz: Fast Point Feature Histograms, ICRA 2009, eq. 1): f1: the angle
/// of the other's normal about v, rad; f2, f3: cosines to v and to the line between them; f4: their
/// distance. First is whose normal is nearer to that line. All 0 and false: no such frame.
bool computePairFeatures(const Eigen::Vector4f& p1, const Eigen::Vector4f& n1,
                         const Eigen::Vector4f& p2, const Eigen::Vector4f& n2, float& f1, float& f2,
                         float& f3, float& f4) {
  f1 = f2 = f3 = f4 = 0.0f;
  Eigen::Vector3f line = (p2 - p1).head<3>(), u = n1.head<3>(), other = n2.head<3>();
  const float distance = line.norm();
  if (distance == 0.0f) return false;
  line /= distance;
  if (std::abs(u.dot(line)) < std::abs(other.dot(line))) {
    u.swap(other);
    line = -line;
  }
  const Eigen::Vector3f across = line.cross(u);
  const float length = across.norm();
  if (length == 0.0f) return false;
  const Eigen::Vector3f v = across / length, w = u.cross(v);
  f1 = std::atan2(w.dot(other), u.dot(other));
  f2 = v.dot(other);
  f3 = u.dot(line);
  f4 = distance;
  return true;
}

// NOLINTEND(readability-identifier-naming)
}  // namespace pcl
