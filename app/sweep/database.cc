#include "app/sweep/database.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <unistd.h>

#include <memory>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

constexpr int kBusy_ms = 10'000;  // Of waiting for another program that writes.
constexpr int kMostValueBytes = 64 << 20;
// Work is counted in SQLite's virtual instructions: a scan of a table takes a few a byte of the
// file.
constexpr int kWorkUnit = 100'000;
constexpr uint64_t kWorkPerByte = 100;
constexpr uint64_t kLeastWork = 50'000'000;  // About a second.

struct Finalise {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Finalise>;

int bind(sqlite3_stmt* statement, int place, const SqlValue& value) {
  if (const auto* whole = std::get_if<int64_t>(&value))
    return sqlite3_bind_int64(statement, place, *whole);
  if (const auto* number = std::get_if<double>(&value))
    return sqlite3_bind_double(statement, place, *number);
  if (const auto* text = std::get_if<std::string>(&value))
    return sqlite3_bind_text64(statement, place, text->data(), text->size(), SQLITE_TRANSIENT,
                               SQLITE_UTF8);
  return sqlite3_bind_null(statement, place);
}

SqlValue column_of(sqlite3_stmt* statement, int column) {
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return int64_t{sqlite3_column_int64(statement, column)};
    case SQLITE_FLOAT:
      return sqlite3_column_double(statement, column);
    case SQLITE_NULL:
      return std::monostate{};
    default: {
      const auto* text = static_cast<const char*>(sqlite3_column_blob(statement, column));
      return std::string(text == nullptr ? "" : text,
                         static_cast<size_t>(sqlite3_column_bytes(statement, column)));
    }
  }
}

}  // namespace

Database::Database(const std::filesystem::path& file, Mode mode) : file_(file) {
  const int flags = mode == Mode::read    ? SQLITE_OPEN_READONLY
                    : mode == Mode::write ? SQLITE_OPEN_READWRITE
                                          : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const int code = sqlite3_open_v2(file.c_str(), &handle_, flags, nullptr);
  if (code != SQLITE_OK) {
    const std::string why = handle_ == nullptr ? "no memory" : sqlite3_errmsg(handle_);
    sqlite3_close_v2(handle_);
    throw InputError(fmt::format("{}: {}", file.string(), why));
  }
  sqlite3_busy_timeout(handle_, kBusy_ms);
  sqlite3_limit(handle_, SQLITE_LIMIT_LENGTH, kMostValueBytes);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  for (const int option : {SQLITE_DBCONFIG_TRUSTED_SCHEMA, SQLITE_DBCONFIG_ENABLE_TRIGGER,
                           SQLITE_DBCONFIG_ENABLE_VIEW})
    sqlite3_db_config(handle_, option, 0, nullptr);
  sqlite3_progress_handler(handle_, kWorkUnit, &Database::count_work, this);
}

uint64_t Database::bytes() const {
  const auto size = [](const std::filesystem::path& file) {
    std::error_code unknown;
    const auto found = std::filesystem::file_size(file, unknown);
    return unknown ? uint64_t{0} : uint64_t{found};
  };
  uint64_t all = size(file_) + size(file_.string() + "-wal");
  for (const auto& [name, file] : attached_) all += size(file);
  return all;
}

void Database::attach(const std::filesystem::path& other, const std::string& name) {
  execute("ATTACH ? AS " + sql_name(name), {std::filesystem::absolute(other).string()});
  attached_[name] = other;
}

void Database::detach(const std::string& name) {
  execute("DETACH " + sql_name(name));
  attached_.erase(name);
}

int Database::count_work(void* database) {
  auto& left = static_cast<Database*>(database)->work_left_;
  if (left == 0) return 1;
  --left;
  return 0;
}

void Database::require_plain_tables() const {
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format(
        "{}: {}, expected plain tables as SEAM writes them: take the file as it was made",
        file_.string(), what));
  };
  query("SELECT type, name, coalesce(sql, '') FROM sqlite_master", {}, [&](const SqlRow& row) {
    const std::string type = text_of(row[0]), name = shown(text_of(row[1]));
    if (type != "table" && type != "index") refuse(fmt::format("holds the {} '{}'", type, name));
    if (type == "table" && text_of(row[2]).starts_with("CREATE VIRTUAL"))
      refuse(fmt::format("holds the virtual table '{}'", name));
  });
  // Its value is worked out whenever it is read.
  query(
      "SELECT t.name, c.name FROM pragma_table_list AS t, pragma_table_xinfo(t.name) AS c "
      "WHERE c.hidden > 1",
      {}, [&](const SqlRow& row) {
        refuse(fmt::format("the table '{}' has the generated column '{}'", shown(text_of(row[0])),
                           shown(text_of(row[1]))));
      });
  const std::string sound = text_of(value("PRAGMA quick_check(1)"));
  if (sound != "ok")
    throw InputError(fmt::format("{}: is damaged: {}", file_.string(), shown(sound)));
}

Database::~Database() {
  sqlite3_close_v2(handle_);
}

void Database::fail(int code) const {
  std::string what = sqlite3_errmsg(handle_);
  const int kind = code & 0xff;
  if (kind == SQLITE_FULL || kind == SQLITE_IOERR) {
    what +=
        " (is the disk full?). What was finished before is kept: make room, and the same command "
        "goes on";
  } else if (kind == SQLITE_BUSY) {
    what = "another program writes this file now";
  } else if (kind == SQLITE_NOTADB) {
    what = "is no SQLite file";
  } else if (kind == SQLITE_INTERRUPT) {
    what = "reading it takes more work than a file of its size can need: it was made to do so";
  } else if (kind == SQLITE_TOOBIG) {
    what = fmt::format("a value of more than {} MiB", kMostValueBytes >> 20);
  }
  throw InputError(fmt::format("{}: {}", file_.string(), what));
}

void Database::execute(const std::string& sql, const std::vector<SqlValue>& values) {
  query(sql, values, [](const SqlRow&) {});
}

void Database::query(const std::string& sql, const std::vector<SqlValue>& values,
                     const std::function<void(const SqlRow&)>& take) const {
  work_left_ = (kLeastWork + kWorkPerByte * bytes()) / kWorkUnit;
  sqlite3_stmt* raw = nullptr;
  int code = sqlite3_prepare_v2(handle_, sql.c_str(), static_cast<int>(sql.size()), &raw, nullptr);
  const Statement statement(raw);
  if (code != SQLITE_OK) fail(code);
  for (size_t i = 0; i < values.size(); ++i) {
    code = bind(raw, static_cast<int>(i) + 1, values[i]);
    if (code != SQLITE_OK) fail(code);
  }
  SqlRow row(static_cast<size_t>(sqlite3_column_count(raw)));
  while ((code = sqlite3_step(raw)) == SQLITE_ROW) {
    for (size_t i = 0; i < row.size(); ++i) row[i] = column_of(raw, static_cast<int>(i));
    take(row);
  }
  if (code != SQLITE_DONE) fail(code);
}

SqlValue Database::value(const std::string& sql, const std::vector<SqlValue>& values) const {
  SqlValue first;
  bool found = false;
  query(sql, values, [&](const SqlRow& row) {
    if (!found && !row.empty()) first = row.front();
    found = true;
  });
  return first;
}

WriterLock::WriterLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CLOEXEC)) {
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const bool taken = descriptor_ >= 0;
  if (taken) ::close(descriptor_);
  throw InputError(
      fmt::format("{}: {}", file.string(),
                  taken ? "another process writes this file now" : "cannot be opened for writing"));
}

WriterLock::~WriterLock() {
  ::close(descriptor_);
}

OwnedDatabase own_database(const std::filesystem::path& file) {
  std::error_code unknown;
  const bool fresh =
      !std::filesystem::exists(file, unknown) || std::filesystem::file_size(file, unknown) == 0;
  OwnedDatabase owned{.lock = nullptr,
                      .database = std::make_unique<Database>(file, Database::Mode::create)};
  if (fresh) owned.database->execute("PRAGMA user_version = 1");  // Now the file is there.
  owned.lock = std::make_unique<WriterLock>(file);
  owned.has_tables = whole_of(owned.database->value("SELECT count(*) FROM sqlite_master")) != 0;
  if (owned.has_tables) owned.database->require_plain_tables();
  return owned;
}

void write_ahead(Database& database) {
  database.value("PRAGMA journal_mode = WAL");
  database.execute("PRAGMA synchronous = NORMAL");
}

std::string text_of(const SqlValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text == nullptr ? "" : *text;
}

int64_t whole_of(const SqlValue& value) {
  const auto* whole = std::get_if<int64_t>(&value);
  return whole == nullptr ? 0 : *whole;
}

std::string sql_name(const std::string& name) {
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

Transaction::~Transaction() {
  if (committed_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const InputError&) {
    // SQLite rolled back by itself, as it does when the disk is full.
  }
}

}  // namespace seam::app
