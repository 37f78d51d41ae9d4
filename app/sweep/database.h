// SQLite behind one small class; nothing else includes its header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

struct sqlite3;

namespace seam::app {

// NULL, a whole number, a number, text.
using SqlValue = std::variant<std::monostate, int64_t, double, std::string>;
using SqlRow = std::vector<SqlValue>;

// Errors are InputErrors that name the file and say what to do. A file may be of a stranger's
// making: views and triggers are never run, a value has at most 64 MiB, and a query takes no more
// work than a file of its size can need.
class Database {
 public:
  enum class Mode { read, write, create };
  Database(const std::filesystem::path& file, Mode mode);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  // `?` in the text takes the values in their order.
  void execute(const std::string& sql, const std::vector<SqlValue>& values = {});
  void query(const std::string& sql, const std::vector<SqlValue>& values,
             const std::function<void(const SqlRow&)>& take) const;
  // Another file, which SQL calls `name` from now on; its size counts for the work of queries.
  void attach(const std::filesystem::path& other, const std::string& name);
  void detach(const std::string& name);
  // Throws InputError where the file is damaged, or holds anything but tables of plain columns.
  void require_plain_tables() const;
  // The first column of the first row; NULL where there is none.
  SqlValue value(const std::string& sql, const std::vector<SqlValue>& values = {}) const;

 private:
  [[noreturn]] void fail(int code) const;
  uint64_t bytes() const;  // Of all files.
  static int count_work(void* database);

  std::filesystem::path file_;
  std::map<std::string, std::filesystem::path> attached_;
  mutable uint64_t work_left_ = 0;  // Of the present query, in units of kWorkUnit.
  sqlite3* handle_ = nullptr;
};

// An advisory lock of a whole file, which ends with the process: no other has one. Throws
// InputError where one has.
class WriterLock {
 public:
  explicit WriterLock(const std::filesystem::path& file);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int descriptor_;
};

// A file that this process alone writes, made where it is not there: nothing in it has changed yet.
struct OwnedDatabase {
  std::unique_ptr<WriterLock> lock;  // Released after the database is closed: last.
  std::unique_ptr<Database> database;
  bool has_tables = false;
};
OwnedDatabase own_database(const std::filesystem::path& file);
// From now on a process that dies loses nothing that was committed; of a computer that does, the
// last few commits may be lost.
void write_ahead(Database& database);

// What a column holds; an empty text and 0 where it holds something else.
std::string text_of(const SqlValue& value);
int64_t whole_of(const SqlValue& value);

// A name as SQL quotes it.
std::string sql_name(const std::string& name);

// All between construction and `commit` happens, or nothing of it.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) {
    database_.execute("BEGIN IMMEDIATE");
  }
  ~Transaction();
  void commit() {
    database_.execute("COMMIT");
    committed_ = true;
  }

 private:
  Database& database_;
  bool committed_ = false;
};

}  // namespace seam::app
