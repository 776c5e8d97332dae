// Kerbs of the reference that the file has lost. Private to the comparison.
#pragma once

#include <string>

#include "inspect/compare.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"

namespace road {

/// The reference at the nodes of every few rows of a map, and the kerbs found there.
struct ReferenceKerbs {
  HeightMap map;
  KerbStrips kerbs;
};

/// Without kerbs where the road is shorter than two such rows.
ReferenceKerbs kerbs_of_reference(const HeightMap& map, const ReferenceHeights& reference,
                                  const CompareOptions& options);

/// Crests of the reference's kerbs against the file's: findings of the kind kerb_loss.
void find_kerb_losses(const HeightMap& map, const ReferenceKerbs& reference,
                      const std::string& name, const CompareOptions& options, Comparison& result);

/// A finding whose place is not known yet.
Finding make_finding(const char* kind, double value, const char* unit, Severity severity,
                     std::string text);

}  // namespace road
