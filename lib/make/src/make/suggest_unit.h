// In which unit a mesh would be a road, where it is none in the one it was read in, or one wider
// than roads are. Private.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "make/question.h"
#include "make/recipe.h"
#include "mesh/mesh.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"
#include "road/clean.h"

namespace road {

/// The roads of a mesh whose size in metres is no road's, in those of `could_be` (at least one) in
/// which it is as wide as roads are; the likeliest first. Where nothing tells the up axis either,
/// or a strip would be asked for, the flags tell that too. None where it is so large that trying
/// takes long.
std::vector<Candidate> candidates_of_unit(const Recipe& recipe, const std::vector<Unit>& could_be);

/// `found`, the roads of a mesh of which nothing tells which of some axes points up; where none of
/// them has a road's size and nobody said the unit, after those in the units in which one has, with
/// flags that tell both.
std::vector<Candidate> likelier_units(const Recipe& recipe, const std::vector<UpAxis>& ups,
                                      std::vector<Candidate> found);

/// Asks for the unit (throws a Question) where what was `refused` is a road in another one, or
/// enlarged: the mesh is cleaned and the road traced as a build would. Where none has a road, but
/// the mesh as it is has one wider or narrower than any, refuses with that (Error). Does nothing
/// where the mesh, as it is, has a road after all (then the refusal has another reason), or where
/// it is so large that trying takes long.
void refuse_in_this_unit(const std::string& refused, const Mesh& mesh, double metres_per_unit,
                         const Recipe& recipe);

/// That a road of which nobody said the unit is wider on the median than roads are, or, where the
/// file states none either (`unit_taken`), as wide all along as is round in feet and not in metres;
/// with the units in which it would be as wide as roads are (tried, where the mesh is not so large
/// that this takes long) and the way to confirm it. Empty where it is not.
std::optional<std::string> doubt_about_width(const Centreline& line, const Mesh& mesh,
                                             const MeshReadReport& read, const Recipe& recipe);

/// What to know of a road wider than most whose unit nobody stated. Empty where it is not.
std::optional<std::string> remark_on_width(const Centreline& line, const MeshReadReport& read);

}  // namespace road
