#include "information.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd whole_matrix(const Information& sums, const DriveSummary& of) {
  const auto kinds = static_cast<Index>(kRoadKinds), knots = static_cast<Index>(of.knots),
             road = kinds * knots, q = static_cast<Index>(of.columns.size());
  MatrixXd out = MatrixXd::Zero(road + q, road + q);
  const Eigen::Map<const MatrixXd> knot(sums.knot.data(), kinds, road),
      next(sums.next.data(), kinds, road), across(sums.across.data(), road, q);
  for (Index k = 0; k < knots; ++k) {
    const Index here = k * kinds, there = (k + 1) % knots * kinds;
    out.block(here, here, kinds, kinds) += knot.middleCols(here, kinds);
    out.block(here, there, kinds, kinds) += next.middleCols(here, kinds);
    out.block(there, here, kinds, kinds) += next.middleCols(here, kinds).transpose();
  }
  out.topRightCorner(road, q) = across;
  out.bottomLeftCorner(q, road) = across.transpose();
  std::size_t at = 0;
  for (Index k = 0; k < q; ++k)
    for (Index l = 0; l <= k; ++l)
      out(road + k, road + l) = out(road + l, road + k) = sums.among[at++];
  return out;
}

}  // namespace explain
