#include "app/sweep/results.h"

#include <fstream>
#include <limits>

#include "app/sweep/one_run.h"
#include "app/sweep/sweep_testing.h"
#include "app/sweep/table.h"

namespace seam::app {
namespace {

const Makers kMakers{"1.0", "aa", "bb"};

RunRecord record(uint64_t run, double value) {
  return {.run = run,
          .key = "k",
          .seed = static_cast<int64_t>(run) + 1,
          .end = "finished",
          .sim_s = 2,
          .wall_s = 0.5,
          .frames = 3,
          .decisions = 4,
          .fingerprint = "0123",
          .kept = {value, std::nullopt}};
}

RunRecord failure(uint64_t run) {
  return {.run = run, .error = "it, \"fell\"\nover"};
}

class Results : public testing::Test {
 protected:
  ResultsFile open(const std::string& name, const Shard& shard = {}) const {
    return ResultsFile::for_writing(folder_.path(name), folder_.plan(), kMakers, shard);
  }
  std::string table(const std::string& name) const {
    const auto results = ResultsFile::for_reading(folder_.path(name));
    std::string text = csv_line(table_columns(results.plan()));
    results.each([&](const RunRecord& r) { text += csv_line(table_cells(results.plan(), r)); });
    return text;
  }
  template <class Action>
  std::string why_not(const Action& action) const {
    try {
      action();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  PlanFolder folder_{
      "vary: [{path: \"robots[0].pose.x_m\", name: x, values: [0.1, 0.2, 0.3]}]\nseeds: [1, 2]\n"
      "keep: {values: [a], expressions: {b: 2 * a}}"};
};

TEST_F(Results, ATableIsInTheOrderOfThePlanWhateverCameFirst) {
  {
    auto first = open("a.sqlite");
    for (uint64_t run = 0; run < 6; ++run) first.add(record(run, 0.1 * static_cast<double>(run)));
    first.close();
    auto second = open("b.sqlite");
    for (uint64_t run = 6; run-- > 0;) second.add(record(run, 0.1 * static_cast<double>(run)));
  }
  EXPECT_EQ(table("a.sqlite"), table("b.sqlite"));
  EXPECT_THAT(table("a.sqlite"),
              testing::StartsWith("run,x,seed,end,sim_s,frames,decisions,fingerprint,red_score,"
                                  "blue_score,a,b,error\n"
                                  "0,0.1,1,finished,2,3,4,0123,,,0,,\n"));
  EXPECT_THAT(table("a.sqlite"), testing::HasSubstr("\n3,0.2,4,finished,2,3,4,0123,,,"
                                                    "0.30000000000000004,,\n"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("a.sqlite-wal")));
}

TEST_F(Results, GoesOnWhereItWas) {
  open("a.sqlite").add(record(4, 1));
  auto again = open("a.sqlite");
  EXPECT_TRUE(again.finished()[4]);
  EXPECT_FALSE(again.finished()[3]);
  EXPECT_EQ(again.counts().finished, 1);
  EXPECT_TRUE(same_result(*again.record(4), record(4, 1)));
  // A run is in it once.
  EXPECT_THROW(again.add(record(4, 1)), InputError);
  EXPECT_EQ(again.counts().finished, 1);
}

TEST_F(Results, AFailureIsToldAndTriedAgain) {
  auto results = open("a.sqlite");
  results.add(failure(2));
  EXPECT_EQ(results.counts().failed, 1);
  EXPECT_FALSE(results.finished()[2]);
  EXPECT_THAT(table("a.sqlite"),
              testing::HasSubstr("2,0.2,0,failed,,,,,,,,,\"it, \"\"fell\"\"\"\n"));
  results.add(record(2, 1));
  EXPECT_EQ(results.counts().failed, 0);
  EXPECT_EQ(results.counts().finished, 1);
}

TEST_F(Results, OtherPlansProgramsAndShardsAreRefusedInWords) {
  open("a.sqlite").add(record(0, 1));
  const auto with = [&](const SweepPlan& plan, const Makers& makers, const Shard& shard) {
    return why_not(
        [&] { ResultsFile::for_writing(folder_.path("a.sqlite"), plan, makers, shard); });
  };
  EXPECT_EQ(with(folder_.plan(), kMakers, {}), "");
  EXPECT_THAT(with(PlanFolder("seeds: [1, 6]").plan(), kMakers, {}),
              testing::HasSubstr("another plan"));
  EXPECT_THAT(with(folder_.plan(), {"1.1", "aa", "bb"}, {}), testing::HasSubstr("SEAM 1.0"));
  EXPECT_THAT(with(folder_.plan(), {"1.0", "aa", "cc"}, {}), testing::HasSubstr("behaviours cc"));
  EXPECT_THAT(with(folder_.plan(), kMakers, {2, 3}), testing::HasSubstr("holds shard 1/1"));
  const auto first = open("a.sqlite");
  EXPECT_THAT(with(folder_.plan(), kMakers, {}), testing::HasSubstr("another process writes"));
}

TEST_F(Results, OtherFilesAreRefusedAndStayAsTheyAre) {
  folder_.write("text", "no results at all, but long enough to be something");
  EXPECT_THAT(why_not([&] { open("text"); }), testing::HasSubstr("is no SQLite file"));
  EXPECT_THAT(why_not([&] { ResultsFile::for_reading(folder_.path("text")); }),
              testing::HasSubstr("is no SQLite file"));
  Database other(folder_.path("other"), Database::Mode::create);
  other.execute("CREATE TABLE things(a)");
  EXPECT_THAT(why_not([&] { open("other"); }), testing::HasSubstr("holds no results"));
  EXPECT_EQ(std::get<std::string>(other.value("PRAGMA journal_mode")), "delete");
  EXPECT_THAT(why_not([&] { ResultsFile::for_reading(folder_.path("none")); }),
              testing::HasSubstr("none"));
}

TEST_F(Results, AFullDiskIsAnErrorThatLosesNothing) {
  const auto path = folder_.path("a.sqlite");
  open("a.sqlite").add(record(0, 1));
  Database database(path, Database::Mode::write);
  const int64_t pages = std::get<int64_t>(database.value("PRAGMA page_count"));
  database.value(fmt::format("PRAGMA max_page_count = {}", pages));
  const std::string why = why_not([&] {
    for (int i = 1; i < 100000; ++i)
      database.execute("INSERT INTO files VALUES(?, ?)",
                       {fmt::format("{}", i), std::string(500, 'x')});
  });
  EXPECT_THAT(why, testing::HasSubstr("is the disk full?"));
  EXPECT_EQ(ResultsFile::for_reading(path).counts().finished, 1);
}

TEST_F(Results, ShardsInAnyOrderAreTheWhole) {
  {
    auto whole = open("whole.sqlite");
    for (uint64_t run = 0; run < 6; ++run) whole.add(record(run, 1));
    for (uint64_t part = 1; part <= 3; ++part) {
      auto shard = open(fmt::format("{}.sqlite", part), {part, 3});
      for (uint64_t run = 0; run < 6; ++run)
        if (shard.shard().has(run)) shard.add(record(run, 1));
      EXPECT_EQ(shard.counts().planned, 2);
      EXPECT_TRUE(shard.missing(10).empty());
    }
    auto merged = open("merged.sqlite");
    for (const char* part : {"3.sqlite", "1.sqlite"})
      merged.take_over(ResultsFile::for_reading(folder_.path(part)));
    EXPECT_THAT(merged.missing(10), testing::ElementsAre(1, 4));
    for (const char* part : {"2.sqlite", "1.sqlite"})  // One done twice, equal to the bit.
      merged.take_over(ResultsFile::for_reading(folder_.path(part)));
  }
  EXPECT_EQ(table("merged.sqlite"), table("whole.sqlite"));
}

TEST_F(Results, DuplicatesThatDifferAreRefused) {
  auto first = open("a.sqlite");
  first.add(record(0, 1));
  first.add(failure(1));
  {
    auto second = open("b.sqlite");
    second.add(record(0, 1 + std::numeric_limits<double>::epsilon()));
  }
  EXPECT_THAT(why_not([&] { first.take_over(ResultsFile::for_reading(folder_.path("b.sqlite"))); }),
              testing::HasSubstr("run 0 differs"));
  {
    auto third = open("c.sqlite");
    third.add(record(1, 3));
  }
  first.take_over(ResultsFile::for_reading(folder_.path("c.sqlite")));  // Of a failure and a run.
  EXPECT_TRUE(same_result(*first.record(1), record(1, 3)));
}

// Files of strangers: nothing in them is run, and what is wrong is named.
TEST_F(Results, FilesOfStrangersAreTablesWithRowsOfThePlan) {
  const std::pair<std::vector<std::string>, const char*> changes[] = {
      {{"UPDATE runs SET run = -5 WHERE run = 0"}, "the row of run -5: expected a run of the plan"},
      {{"UPDATE runs SET run = 6 WHERE run = 0"},
       "the row of run 6: expected a run of the plan, 0 to 5"},
      {{"ALTER TABLE runs RENAME TO kept",
        "CREATE VIEW runs AS SELECT kept.* FROM kept, (WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL "
        "SELECT x + 1 FROM c) SELECT x FROM c)"},
       "holds the view 'runs'"},
      {{"CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END"},
       "holds the trigger 't'"},
      {{"CREATE TABLE more(a, b AS (hex(zeroblob(400000000))))"}, "the generated column 'b'"},
      {{"UPDATE runs SET red_score = 1e300 WHERE run = 1"}, "the row of run 1, column red_score"},
      {{"UPDATE runs SET frames = -1 WHERE run = 1"}, "the row of run 1, column frames"},
      {{"UPDATE runs SET end = 3.5 WHERE run = 1", "UPDATE runs SET end = x'00' WHERE run = 1",
        "UPDATE runs SET key = NULL WHERE run = 1"},
       "the row of run 1, column key"},
      {{"UPDATE runs SET wall_s = 9e999 WHERE run = 1"}, "the row of run 1, column wall_s"}};
  for (const auto& [statements, expected] : changes) {
    const auto file = folder_.path("stranger.sqlite");
    std::filesystem::remove(file);
    {
      auto results = open("stranger.sqlite");
      for (uint64_t run = 0; run < 3; ++run) results.add(record(run, 1));
      results.close();
    }
    {
      Database database(file, Database::Mode::write);
      for (const std::string& statement : statements) database.execute(statement);
    }
    EXPECT_THAT(why_not([&] { table("stranger.sqlite"); }), testing::HasSubstr(expected));
  }
}

TEST_F(Results, AQueryEndsWhateverItIsAsked) {
  open("a.sqlite").close();
  const Database database(folder_.path("a.sqlite"), Database::Mode::read);
  EXPECT_THAT(why_not([&] {
                database.value(
                    "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) "
                    "SELECT max(x) FROM c");
              }),
              testing::HasSubstr("more work than a file of its size can need"));
  EXPECT_THAT(why_not([&] { database.value("SELECT hex(zeroblob(400000000))"); }),
              testing::HasSubstr("a value of more than 64 MiB"));
  EXPECT_EQ(whole_of(database.value("SELECT 7")), 7);
}

TEST_F(Results, ADamagedFileIsNamed) {
  {
    auto results = open("a.sqlite");
    for (uint64_t run = 0; run < 6; ++run) results.add(record(run, 1));
    results.close();
  }
  const auto file = folder_.path("a.sqlite");
  const auto bytes = static_cast<std::streamoff>(std::filesystem::file_size(file));
  std::fstream damage(file, std::ios::in | std::ios::out | std::ios::binary);
  damage.seekp(bytes - 40);
  damage << std::string(30, '\xff');
  damage.close();
  EXPECT_THAT(why_not([&] { table("a.sqlite"); }), testing::HasSubstr("a.sqlite"));
}

TEST(Shard, CoversThePlanOnce) {
  for (uint64_t runs : {1u, 5u, 6u, 7u}) {
    uint64_t all = 0;
    for (uint64_t part = 1; part <= 3; ++part) {
      uint64_t count = 0;
      for (uint64_t run = 0; run < runs; ++run) count += Shard{part, 3}.has(run);
      EXPECT_EQ(count, (Shard{part, 3}.runs_of(runs)));
      all += count;
    }
    EXPECT_EQ(all, runs);
  }
  EXPECT_EQ(shard_from_text("2/3"), (Shard{2, 3}));
  for (const char* text : {"0/3", "4/3", "2", "2/", "/3", "2/3x", "-1/3"})
    EXPECT_THROW(shard_from_text(text), UsageError) << text;
}

TEST(RunRecord, TravelsAsTextToTheBit) {
  RunRecord before = record(7, 0.1 + 0.2);
  before.red_score = 3;
  before.kept.push_back(-1e-300);
  const RunRecord after = record_from_text(to_text(before));
  EXPECT_TRUE(same_result(before, after));
  EXPECT_EQ(after.key, before.key);
  EXPECT_EQ(record_from_text(to_text(failure(1))).error, failure(1).error);
}

}  // namespace
}  // namespace seam::app
