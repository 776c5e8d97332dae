#include <gtest/gtest.h>
#include <sqlite3.h>

#include "campaign/results.h"
#include "campaign/results_folder.h"

namespace database_test {

std::string asked(const std::string& path, const char* question) {
  sqlite3* database = nullptr;
  std::string answer;
  EXPECT_EQ(::sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  const auto row = [](void* out, int columns, char** cells, char**) {
    for (int i = 0; i < columns; ++i)
      *static_cast<std::string*>(out) += std::string(cells[i] == nullptr ? "-" : cells[i]) + "|";
    return 0;
  };
  EXPECT_EQ(::sqlite3_exec(database, question, row, &answer, nullptr), SQLITE_OK)
      << ::sqlite3_errmsg(database);
  ::sqlite3_close(database);
  return answer;
}

TEST(Database, AnswersQuestionsAndHasTheSameBytesAgain) {
  const cli::Folder folder;
  campaign_test::write_results(folder, "it's; DROP TABLE job");
  const campaign::Campaign read = campaign::read_campaign(folder.path());
  const std::string bytes = campaign::database_of(read), path = folder / "x.sqlite";
  EXPECT_TRUE(bytes == campaign::database_of(read));
  cli::write(path, bytes);
  EXPECT_EQ(asked(path, "PRAGMA integrity_check"), "ok|");
  EXPECT_EQ(asked(path, "SELECT name FROM campaign"), "three <jobs>|");
  EXPECT_EQ(asked(path, "SELECT id, state, exit_code, message FROM job ORDER BY rowid"),
            "road/a|done|0||road/b|failed|1|it's; DROP TABLE job|"
            "lap/b+car|blocked|-|needs road/b|lap/a+car|not run|-||");
  EXPECT_EQ(asked(path, "SELECT value, unit FROM fact WHERE job='road/a' AND name='length'"),
            "1234.25|m|");
  EXPECT_EQ(asked(path, "SELECT path, bytes, sha256 FROM output"), "road/a/a.crg|3|00ff|");
}

}  // namespace database_test
