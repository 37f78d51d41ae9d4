// Each process of tests has a temporary folder of its own, so that tests that run side by side do
// not write over each other; it is gone when they have run.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace seam {
namespace {

class OwnFolder : public testing::Environment {
 public:
  void SetUp() override {
    std::string path = testing::TempDir() + "seam-tests-XXXXXX";
    ASSERT_NE(mkdtemp(path.data()), nullptr) << path;
    folder_ = path;
    setenv("TEST_TMPDIR", folder_.c_str(), 1);
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

 private:
  std::filesystem::path folder_;
};

[[maybe_unused]] const testing::Environment* const kFolder =
    testing::AddGlobalTestEnvironment(new OwnFolder);

}  // namespace
}  // namespace seam
