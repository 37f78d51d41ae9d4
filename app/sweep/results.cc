#include "app/sweep/results.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kResultsFormat = "seam-sweep-results/1";
constexpr const char* kFixedColumns[] = {
    "run",    "key",    "failed",    "error",       "seed",      "end",       "sim_s",
    "wall_s", "frames", "decisions", "fingerprint", "red_score", "blue_score"};
constexpr size_t kFixed = std::size(kFixedColumns);

std::optional<double> number_of(const SqlValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* whole = std::get_if<int64_t>(&value)) return static_cast<double>(*whole);
  return std::nullopt;
}
SqlValue sql_of(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? SqlValue(*value) : SqlValue();
}
SqlValue sql_of(const std::optional<int>& value) {
  return value ? SqlValue(int64_t{*value}) : SqlValue();
}

// A setting as SQL sees it: a number where it is one.
SqlValue sql_of(const WrittenValue& value) {
  const char* end = value.text.data() + value.text.size();
  int64_t whole = 0;
  const auto as_whole = std::from_chars(value.text.data(), end, whole);
  if (value.plain && as_whole.ec == std::errc() && as_whole.ptr == end) return whole;
  double number = 0;
  const auto as_number = std::from_chars(value.text.data(), end, number);
  if (value.plain && as_number.ec == std::errc() && as_number.ptr == end) return number;
  return value.text;
}

// Another file, which SQL calls `other` meanwhile.
class Attachment {
 public:
  Attachment(Database& database, const fs::path& file) : database_(database) {
    database_.attach(file, "other");
  }
  ~Attachment() { database_.detach("other"); }
  Attachment(const Attachment&) = delete;
  Attachment& operator=(const Attachment&) = delete;

 private:
  Database& database_;
};

// The columns of a row, each of its kind: a file may be of a stranger's making.
class RowReader {
 public:
  RowReader(const fs::path& file, const SqlRow& row) : file_(file), row_(row) {}

  // Failed runs have no numbers.
  bool has(size_t column) const {
    return !failed() || !std::holds_alternative<std::monostate>(row_[column]);
  }
  std::string text(size_t column) const {
    if (!std::holds_alternative<std::string>(row_[column])) refuse(column, "a text");
    return text_of(row_[column]);
  }
  int64_t whole(size_t column, int64_t least) const {
    const auto* found = std::get_if<int64_t>(&row_[column]);
    if (found == nullptr || *found < least)
      refuse(column, least < 0 ? "a whole number" : "a whole number from 0 on");
    return *found;
  }
  double seconds(size_t column) const {
    const auto found = number_of(row_[column]);
    if (!found || !(*found >= 0 && *found < 1e12)) refuse(column, "seconds");
    return *found;
  }
  std::optional<int> score(size_t column) const {
    if (std::holds_alternative<std::monostate>(row_[column])) return std::nullopt;
    const int64_t found = whole(column, 0);
    if (found > std::numeric_limits<int>::max()) refuse(column, "a score");
    return static_cast<int>(found);
  }

 private:
  [[noreturn]] void refuse(size_t column, const char* expected) const {
    throw InputError(fmt::format("{}: table runs, the row of run {}, column {}: expected {}",
                                 file_.string(), whole_of(row_[0]), kFixedColumns[column],
                                 expected));
  }
  bool failed() const { return !text(3).empty(); }

  const fs::path& file_;
  const SqlRow& row_;
};

RunRecord record_of(const fs::path& file, const SqlRow& row) {
  const RowReader read(file, row);
  RunRecord record;
  record.run = static_cast<uint64_t>(read.whole(0, 0));
  record.key = read.text(1);
  record.error = read.text(3);
  record.seed = read.whole(4, std::numeric_limits<int64_t>::min());
  record.end = read.text(5);
  record.sim_s = read.has(6) ? read.seconds(6) : 0;
  record.wall_s = read.seconds(7);
  record.frames = read.has(8) ? static_cast<uint64_t>(read.whole(8, 0)) : 0;
  record.decisions = read.has(9) ? static_cast<uint64_t>(read.whole(9, 0)) : 0;
  record.fingerprint = read.text(10);
  record.red_score = read.score(11);
  record.blue_score = read.score(12);
  for (size_t i = kFixed; i < row.size(); ++i) record.kept.push_back(number_of(row[i]));
  return record;
}

}  // namespace

std::string to_string(const Shard& shard) {
  return fmt::format("{}/{}", shard.part, shard.parts);
}

Shard shard_from_text(const std::string& text) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto part = std::from_chars(text.data(), end, shard.part);
  const bool slash = part.ec == std::errc() && part.ptr != end && *part.ptr == '/';
  const auto parts =
      slash ? std::from_chars(part.ptr + 1, end, shard.parts) : std::from_chars_result{end, {}};
  if (!slash || parts.ec != std::errc() || parts.ptr != end || shard.part < 1 ||
      shard.part > shard.parts)
    throw UsageError(fmt::format("--shard {}: expected k/n with k from 1 to n, such as 1/3", text));
  return shard;
}

bool same_result(const RunRecord& a, const RunRecord& b) {
  return a.run == b.run && a.seed == b.seed && a.end == b.end && a.sim_s == b.sim_s &&
         a.frames == b.frames && a.decisions == b.decisions && a.fingerprint == b.fingerprint &&
         a.red_score == b.red_score && a.blue_score == b.blue_score && a.kept == b.kept;
}

ResultsFile::ResultsFile(fs::path path, std::unique_ptr<Database> database)
    : path_(std::move(path)), database_(std::move(database)) {}
ResultsFile::ResultsFile(ResultsFile&&) noexcept = default;
ResultsFile::~ResultsFile() = default;

ResultsFile ResultsFile::for_reading(const fs::path& file) {
  ResultsFile results(file, std::make_unique<Database>(file, Database::Mode::read));
  results.database_->require_plain_tables();
  results.read_head(/*known=*/nullptr);
  return results;
}

ResultsFile ResultsFile::for_writing(const fs::path& file, const SweepPlan& plan,
                                     const Makers& makers, const Shard& shard) {
  OwnedDatabase owned = own_database(file);
  ResultsFile results(file, std::move(owned.database));
  results.lock_ = std::move(owned.lock);
  if (owned.has_tables) results.read_head(&plan);  // Before another program's file is changed.
  write_ahead(*results.database_);
  // Nothing is lost of a plan of which there is no run: its first one showed a mistake in it.
  const bool anew = owned.has_tables && results.plan().fingerprint() != plan.fingerprint() &&
                    std::get<int64_t>(results.database_->value("SELECT count(*) FROM runs")) == 0;
  if (anew)
    for (const char* table : {"meta", "files", "runs"})
      results.database_->execute(fmt::format("DROP TABLE {}", table));
  if (!owned.has_tables || anew) {
    results.create(plan, makers, shard);
    results.read_head(&plan);
  }
  const std::string where = file.string();
  if (results.plan().texts() != plan.texts() && results.plan().fingerprint() != plan.fingerprint())
    throw InputError(fmt::format(
        "{}: holds the results of another plan ({}), or this one, its scenario or a file that they "
        "name has changed since: give another --out, or the plan as it was",
        where, results.plan().texts().name));
  if (results.makers() != makers)
    throw InputError(fmt::format(
        "{}: was made by other programs: SEAM {} ({}) with behaviours {}; this is SEAM {} ({}) "
        "with "
        "behaviours {}. Give another --out; `seam sweep rerun` shows whether the results still "
        "agree",
        where, results.makers().version, results.makers().program, results.makers().behaviours,
        makers.version, makers.program, makers.behaviours));
  if (results.shard() != shard)
    throw InputError(fmt::format("{}: holds shard {} of the plan, not {}: give another --out",
                                 where, to_string(results.shard()), to_string(shard)));
  return results;
}

void ResultsFile::create(const SweepPlan& plan, const Makers& makers, const Shard& shard) {
  const PlanTexts& texts = plan.texts();
  Transaction transaction(*database_);
  database_->execute("CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID");
  const auto put = [&](const char* key, const std::string& value) {
    database_->execute("INSERT INTO meta VALUES(?, ?)", {std::string(key), value});
  };
  put("format", kResultsFormat);
  put("plan_name", texts.name);
  put("plan", texts.plan);
  put("scenario_name", texts.scenario_name);
  put("scenario", texts.scenario);
  put("runs", fmt::format("{}", plan.runs()));
  put("version", makers.version);
  put("program", makers.program);
  put("behaviours", makers.behaviours);
  put("shard", to_string(shard));
  database_->execute("CREATE TABLE files(name TEXT PRIMARY KEY, text TEXT) WITHOUT ROWID");
  for (const auto& [name, text] : texts.files)
    database_->execute("INSERT INTO files VALUES(?, ?)", {name, text});
  std::string columns =
      "run INTEGER PRIMARY KEY, key TEXT, failed INTEGER, error TEXT, seed INTEGER, end TEXT, "
      "sim_s REAL, wall_s REAL, frames INTEGER, decisions INTEGER, fingerprint TEXT, red_score "
      "INTEGER, blue_score INTEGER";
  for (const std::string& column : plan.keep().columns()) columns += ", " + sql_name(column);
  for (const std::string& parameter : plan.parameters()) {
    if (parameter != "seed") columns += ", " + sql_name(parameter);
  }
  database_->execute("CREATE TABLE runs(" + columns + ")");
  transaction.commit();
}

void ResultsFile::read_head(const SweepPlan* known) {
  const bool ours =
      std::get<int64_t>(database_->value("SELECT count(*) FROM sqlite_master WHERE name IN "
                                         "('meta', 'files', 'runs')")) == 3;
  const auto get = [&](const char* key) {
    return text_of(database_->value("SELECT value FROM meta WHERE key = ?", {std::string(key)}));
  };
  if (!ours || get("format") != kResultsFormat)
    throw InputError(fmt::format("{}: holds no results of `seam sweep` (expected {})",
                                 path_.string(), kResultsFormat));
  PlanTexts texts{get("plan_name"), get("plan"), get("scenario_name"), get("scenario"), {}};
  database_->query("SELECT name, text FROM files", {},
                   [&](const SqlRow& row) { texts.files[text_of(row[0])] = text_of(row[1]); });
  if (known != nullptr && known->texts() == texts) {
    plan_.emplace(*known);
  } else {
    plan_.emplace(SweepPlan::from_texts(texts));
  }
  makers_ = {get("version"), get("program"), get("behaviours")};
  shard_ = shard_from_text(get("shard"));
  // Whoever reads rows asks the plan about their numbers.
  database_->query(
      "SELECT run FROM runs WHERE typeof(run) <> 'integer' OR run < 0 OR run >= ? LIMIT 1",
      {static_cast<int64_t>(plan_->runs())}, [&](const SqlRow& row) {
        throw InputError(
            fmt::format("{}: table runs, the row of run {}: expected a run of the plan, 0 to {}",
                        path_.string(), whole_of(row[0]), plan_->runs() - 1));
      });
}

std::vector<std::string> ResultsFile::columns() const {
  std::vector<std::string> names(std::begin(kFixedColumns), std::end(kFixedColumns));
  for (const std::string& column : plan_->keep().columns()) names.push_back(sql_name(column));
  return names;
}

void ResultsFile::add(const RunRecord& record) {
  // Nothing of a failed run is averaged by accident.
  const auto of_whole = [&](SqlValue value) { return record.failed() ? SqlValue() : value; };
  std::vector<SqlValue> values = {static_cast<int64_t>(record.run),
                                  record.key,
                                  int64_t{record.failed()},
                                  record.error,
                                  record.seed,
                                  record.end,
                                  of_whole(record.sim_s),
                                  record.wall_s,
                                  of_whole(static_cast<int64_t>(record.frames)),
                                  of_whole(static_cast<int64_t>(record.decisions)),
                                  record.fingerprint,
                                  sql_of(record.red_score),
                                  sql_of(record.blue_score)};
  const size_t kept = plan_->keep().columns().size();
  for (size_t i = 0; i < kept; ++i)
    values.push_back(i < record.kept.size() ? sql_of(record.kept[i]) : SqlValue());
  const RunSettings settings = plan_->settings(record.run);
  for (size_t i = 0; i < settings.values.size(); ++i) {
    if (plan_->parameters()[i] != "seed") values.push_back(sql_of(settings.values[i]));
  }
  std::string places;
  for (size_t i = 0; i < values.size(); ++i) places += i == 0 ? "?" : ", ?";
  Transaction transaction(*database_);
  database_->execute("DELETE FROM runs WHERE run = ? AND failed",
                     {static_cast<int64_t>(record.run)});
  database_->execute("INSERT INTO runs VALUES(" + places + ")", values);
  transaction.commit();
}

std::vector<bool> ResultsFile::finished() const {
  std::vector<bool> all(plan_->runs(), false);
  database_->query("SELECT run FROM runs WHERE NOT failed", {}, [&](const SqlRow& row) {
    const auto run = static_cast<uint64_t>(whole_of(row[0]));
    if (run < all.size()) all[run] = true;
  });
  return all;
}

SweepCounts ResultsFile::counts() const {
  SweepCounts counts{.planned = shard_.runs_of(plan_->runs())};
  database_->query("SELECT count(*), total(failed), total(wall_s) FROM runs", {},
                   [&](const SqlRow& row) {
                     counts.failed = static_cast<uint64_t>(number_of(row[1]).value_or(0));
                     counts.finished = static_cast<uint64_t>(whole_of(row[0])) - counts.failed;
                     counts.wall_s = number_of(row[2]).value_or(0);
                   });
  return counts;
}

std::optional<RunRecord> ResultsFile::record(uint64_t run) const {
  std::optional<RunRecord> found;
  database_->query(fmt::format("SELECT {} FROM runs WHERE run = ?", fmt::join(columns(), ", ")),
                   {static_cast<int64_t>(run)},
                   [&](const SqlRow& row) { found = record_of(path_, row); });
  return found;
}

void ResultsFile::each(const std::function<void(const RunRecord&)>& take) const {
  database_->query(fmt::format("SELECT {} FROM runs ORDER BY run", fmt::join(columns(), ", ")), {},
                   [&](const SqlRow& row) { take(record_of(path_, row)); });
}

std::vector<uint64_t> ResultsFile::missing(size_t most) const {
  std::vector<bool> there(plan_->runs(), false);
  database_->query("SELECT run FROM runs", {}, [&](const SqlRow& row) {
    const auto run = static_cast<uint64_t>(whole_of(row[0]));
    if (run < there.size()) there[run] = true;
  });
  std::vector<uint64_t> runs;
  for (uint64_t run = 0; run < there.size() && runs.size() < most; ++run) {
    if (!there[run] && shard_.has(run)) runs.push_back(run);
  }
  return runs;
}

void ResultsFile::take_over(const ResultsFile& other) {
  const Attachment attachment(*database_, other.path());
  Transaction transaction(*database_);
  const std::string both =
      "FROM main.runs AS a JOIN other.runs AS b USING (run) WHERE NOT a.failed AND NOT b.failed";
  std::vector<uint64_t> shared;
  database_->query("SELECT run " + both, {}, [&](const SqlRow& row) {
    shared.push_back(static_cast<uint64_t>(whole_of(row[0])));
  });
  for (const uint64_t run : shared) {
    if (!same_result(*record(run), *other.record(run)))
      throw InputError(fmt::format(
          "{}: run {} differs from the same run in another of the files: fingerprint {} and {}. "
          "Runs are pure functions of the plan: `seam sweep rerun FILE --run {}` shows which of "
          "the files this program agrees with",
          other.path().string(), run, other.record(run)->fingerprint, record(run)->fingerprint,
          run));
  }
  database_->execute(
      "DELETE FROM main.runs WHERE failed AND run IN (SELECT run FROM other.runs WHERE NOT "
      "failed)");
  database_->execute("INSERT OR IGNORE INTO main.runs SELECT * FROM other.runs");
  transaction.commit();
}

void ResultsFile::close() {
  try {
    database_->value("PRAGMA journal_mode = DELETE");
  } catch (const InputError&) {
    // Somebody reads it now: it stays as whole as it is, with a file beside it.
  }
  database_.reset();
  lock_.reset();
}

}  // namespace seam::app
