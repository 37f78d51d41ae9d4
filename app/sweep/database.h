// SQLite behind one small class; nothing else includes its header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <variant>
#include <vector>

struct sqlite3;

namespace seam::app {

// NULL, a whole number, a number, text.
using SqlValue = std::variant<std::monostate, int64_t, double, std::string>;
using SqlRow = std::vector<SqlValue>;

// Errors are InputErrors that name the file and say what to do.
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
  // The first column of the first row; NULL where there is none.
  SqlValue value(const std::string& sql, const std::vector<SqlValue>& values = {}) const;

 private:
  [[noreturn]] void fail(int code) const;

  std::filesystem::path file_;
  sqlite3* handle_ = nullptr;
};

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
