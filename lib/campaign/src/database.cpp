#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>
#include <memory>

#include "base/error.h"
#include "campaign/results.h"

namespace campaign {
namespace {

constexpr const char* kTables =
    "PRAGMA encoding='UTF-8';"
    "BEGIN;"
    "CREATE TABLE campaign(name TEXT NOT NULL);"
    "CREATE TABLE job(id TEXT PRIMARY KEY, kind TEXT NOT NULL, subject TEXT NOT NULL,"
    " state TEXT NOT NULL, exit_code INTEGER, message TEXT NOT NULL, page TEXT NOT NULL);"
    "CREATE TABLE fact(job TEXT NOT NULL REFERENCES job(id), name TEXT NOT NULL, value REAL,"
    " unit TEXT NOT NULL, text TEXT NOT NULL, PRIMARY KEY(job, name));"
    "CREATE TABLE output(job TEXT NOT NULL REFERENCES job(id), path TEXT NOT NULL,"
    " bytes INTEGER NOT NULL, sha256 TEXT NOT NULL, PRIMARY KEY(job, path));";

class Database {
 public:
  Database() {
    sqlite3* opened = nullptr;
    const int code = ::sqlite3_open(":memory:", &opened);
    database_.reset(opened);
    if (code != SQLITE_OK) fail();
    execute(kTables);
  }

  void execute(const char* statements) {
    if (::sqlite3_exec(database_.get(), statements, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }

  /// One INSERT; its values are bound in order.
  class Row {
   public:
    Row(Database& database, const char* statement) : database_(database) {
      sqlite3_stmt* prepared = nullptr;
      if (::sqlite3_prepare_v2(database.database_.get(), statement, -1, &prepared, nullptr) !=
          SQLITE_OK)
        database.fail();
      statement_.reset(prepared);
    }
    Row& text(const std::string& value) {
      return bound(::sqlite3_bind_text64(statement_.get(), ++column_, value.data(), value.size(),
                                         SQLITE_TRANSIENT, SQLITE_UTF8));
    }
    Row& number(double value) {
      return bound(std::isfinite(value) ? ::sqlite3_bind_double(statement_.get(), ++column_, value)
                                        : ::sqlite3_bind_null(statement_.get(), ++column_));
    }
    Row& integer(std::int64_t value) {
      return bound(::sqlite3_bind_int64(statement_.get(), ++column_, value));
    }
    Row& nothing() { return bound(::sqlite3_bind_null(statement_.get(), ++column_)); }
    void insert() {
      if (::sqlite3_step(statement_.get()) != SQLITE_DONE) database_.fail();
      ::sqlite3_reset(statement_.get());
      column_ = 0;
    }

   private:
    Row& bound(int code) {
      if (code != SQLITE_OK) database_.fail();
      return *this;
    }
    struct Finalize {
      void operator()(sqlite3_stmt* statement) const { ::sqlite3_finalize(statement); }
    };
    Database& database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
    int column_ = 0;
  };

  std::string bytes() {
    sqlite3_int64 size = 0;
    struct Free {
      void operator()(unsigned char* memory) const { ::sqlite3_free(memory); }
    };
    const std::unique_ptr<unsigned char, Free> image(
        ::sqlite3_serialize(database_.get(), "main", &size, 0));
    if (!image) fail();
    return {reinterpret_cast<const char*>(image.get()), static_cast<std::size_t>(size)};
  }

 private:
  [[noreturn]] void fail() const {
    throw base::Error(fmt::format("SQLite: {}", ::sqlite3_errmsg(database_.get())));
  }
  struct Close {
    void operator()(sqlite3* database) const { ::sqlite3_close(database); }
  };
  std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace

std::string database_of(const Campaign& campaign) {
  Database database;
  Database::Row(database, "INSERT INTO campaign VALUES(?)").text(campaign.name).insert();
  {
    Database::Row job_row(database, "INSERT INTO job VALUES(?,?,?,?,?,?,?)"),
        fact_row(database, "INSERT OR IGNORE INTO fact VALUES(?,?,?,?,?)"),
        output_row(database, "INSERT OR IGNORE INTO output VALUES(?,?,?,?)");
    for (const Job& job : campaign.jobs) {
      job_row.text(job.id).text(job.kind).text(job.subject).text(word_of(job.state));
      if (job.exit_code < 0)
        job_row.nothing();
      else
        job_row.integer(job.exit_code);
      job_row.text(job.message).text(job.page).insert();
      for (const Fact& fact : job.facts)
        fact_row.text(job.id)
            .text(fact.name)
            .number(fact.value)
            .text(fact.unit)
            .text(fact.text)
            .insert();
      for (const Output& output : job.outputs)
        output_row.text(job.id)
            .text(output.path)
            .integer(static_cast<std::int64_t>(output.bytes))
            .text(output.sha256)
            .insert();
    }
  }
  database.execute("COMMIT");
  return database.bytes();
}

}  // namespace campaign
