// Finished stages of a run, kept until the run is complete.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace explain {

/// Keeps what finished stages gave in FOLDER/.unfinished, each in a file of its own named after the
/// stage and `inputs`, a hash of everything that the result depends on. A run that is killed leaves
/// them; the next run over the same inputs takes them up, one over others removes them.
class Stages {
 public:
  Stages(std::string folder, const std::string& inputs);

  /// What the stage gave before, or what `make` gives now. Kept bytes that `read` throws on are
  /// made anew. Different stages may be asked for from different threads.
  template <class T, class Make, class Read, class Bytes>
  T get(const std::string& stage, Make make, Read read, Bytes bytes) const {
    std::string kept;
    if (load(stage, kept)) try {
        return read(kept);
      } catch (const std::exception&) {
      }
    T made = make();
    keep(stage, bytes(made));
    return made;
  }
  std::vector<std::string> taken_up() const;  ///< stages that an earlier run left
  /// Parts of the first stage.
  bool load_part(const std::string& part, std::string& bytes) const;
  void keep_part(const std::string& part, const std::string& bytes) const;
  std::string scratch() const;  ///< an empty folder that goes with the stages
  void done() const;            ///< removes them all

 private:
  std::string path(const std::string& stage) const { return folder_ + "/" + stage + "-" + inputs_; }
  bool load(const std::string& stage, std::string& bytes) const;
  void keep(const std::string& stage, const std::string& bytes) const;
  std::string folder_, inputs_;
};

}  // namespace explain
