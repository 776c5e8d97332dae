// plan.json of a campaign and, after a line "@@", the state of its job road/x.
#include <algorithm>

#include "base/error.h"
#include "campaign/results.h"
#include "fuzz/target.h"

void fuzz::run(std::string_view bytes) {
  constexpr std::string_view kBorder = "\n@@\n";
  const std::size_t border = bytes.find(kBorder);
  std::filesystem::create_directories(folder() / "state/road");
  const std::string path = folder().put("plan.json", bytes.substr(0, border));
  folder().put("state/road/x.json",
               border == std::string_view::npos ? "{}" : bytes.substr(border + kBorder.size()));
  try {
    const campaign::Campaign read =
        campaign::read_campaign(std::filesystem::path(path).parent_path());
    for (const campaign::Job& job : read.jobs) {
      require(job.message.find('\n') == std::string::npos, "messages of one line");
      require(job.page.find("..") != 0 && job.page.find('/') != 0, "pages inside the folder");
    }
    const std::string table = campaign::table_of(read);
    require(std::count(table.begin(), table.end(), '\n') > static_cast<long>(read.jobs.size()),
            "a row for every job");
  } catch (const base::Error& error) {
    require_refusal(error, path);
  }
}
