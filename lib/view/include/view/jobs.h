// Commands of the tools that run while the page is used.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace view {

struct Job {
  int id = 0;
  std::vector<std::string> command;  ///< as somebody would type it
  std::string folder;                ///< where it runs
  bool is_running = true;
  int exit_code = 0;     ///< 128 + signal where one ended it; 127: could not be started
  double seconds = 0.0;  ///< so far, or in all
  std::string progress;  ///< the last line that it showed while it worked
  std::string messages;  ///< what it said on standard error, the last kMostMessages bytes
  std::size_t output_bytes = 0;
};
constexpr std::size_t kMostMessages = 64'000, kMostOutput = 2'000'000'000;
constexpr std::size_t kMostRunning = 4, kMostKept = 50, kMostOutputs = 8;

class Jobs {
 public:
  /// `tools`: the folder with the programs; a program that is not there is looked for in PATH.
  explicit Jobs(std::string tools);
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;
  ~Jobs();  ///< ends what runs

  /// Starts a program; its standard error is a terminal, so that it shows how far it is. Throws
  /// Refusal (429) when kMostRunning run already.
  int start(const std::vector<std::string>& command, const std::string& folder);
  /// SIGTERM, and SIGKILL two seconds later. Nothing where it has ended.
  void stop(int id);
  std::vector<Job> list() const;  ///< the last kMostKept, the newest last
  /// Its standard output, whole; throws Error while it runs and where it is not known. Empty once
  /// kMostOutputs others have begun.
  std::string output(int id) const;

 private:
  struct Running;
  std::string tools_;
  std::unique_ptr<Running> running_;
};

}  // namespace view
