// What to ask when it cannot be told which road of a mesh is meant.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "make/recipe.h"
#include "mesh/error.h"

namespace road {

/// A road that could be meant; a build with these flags was tried as far as its reference line, and
/// nothing speaks against it (doubts_about()).
struct Candidate {
  std::string flags;                      ///< "--route 1,2 3,4 1,2"
  std::vector<Eigen::Vector3d> points_m;  ///< its middle
  double length_m = 0.0, width_m = 0.0;
  bool closed = false;
};

/// The refusal of a mesh with the answers that would lead on.
class Question : public NotUsable {
 public:
  Question(const std::string& what, std::vector<Candidate> candidates)
      : NotUsable(what), candidates_(std::move(candidates)) {}
  const std::vector<Candidate>& candidates() const { return candidates_; }

 private:
  std::vector<Candidate> candidates_;
};

/// The longest ways over everything that names or shape call road, at most `most` that differ and
/// that can be built; the longest first, closed ones before open ones. None: none can.
std::vector<Candidate> candidates(const Mesh& mesh, const Recipe& recipe, std::size_t most = 6);

/// Answers to which axis points up.
struct UpAnswers {
  std::vector<Candidate> candidates;  ///< what is told comes first
  std::optional<UpAxis> told;         ///< by the crown and banks of the road, and by ground over it
};

/// The same for a mesh of which nothing tells which axis points up: in each of `could_be` the mesh
/// is read anew, and the longest road that clean() finds in it is tried. Where a line is there in
/// both directions, its positive one is there mirrored, too. Meshes of more than a million
/// triangles are not tried. Where that would ask for a strip, the strips are the answers.
UpAnswers candidates_of_up(const Recipe& recipe, const std::vector<UpAxis>& could_be);

/// The strips side by side that shape alone shows, each with a place on it as --near-m, and all of
/// the ground where that is a closed road.
std::vector<Candidate> candidates_of_strips(const Mesh& mesh, const Recipe& recipe);

/// The mesh from above in grey, each candidate in a colour with its number, its length beside it;
/// as the bytes of a PNG file.
std::string question_picture(const std::string& title, const Mesh& mesh,
                             const std::vector<Candidate>& candidates);

}  // namespace road
