#include "app/trust/log_signature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::app {
namespace {

using ::testing::HasSubstr;

class LogSignature : public ::testing::Test {
 protected:
  LogSignature() {
    std::string pattern = ::testing::TempDir() + "/seam-sign-XXXXXX";
    folder_ = mkdtemp(pattern.data());
    log_ = folder_ / "a.mcap";
    write_file_atomically(log_, std::string(3'000'000, 'x'));
  }
  ~LogSignature() override { std::filesystem::remove_all(folder_); }

  // OpenSSL's own program makes the keys and checks the signature.
  int openssl(const std::string& arguments) const {
    return std::system(
        ("cd '" + folder_.string() + "' && openssl " + arguments + " >/dev/null 2>&1").c_str());
  }
  void make_key(const std::string& name, const std::string& algorithm = "ed25519") const {
    ASSERT_EQ(openssl("genpkey -algorithm " + algorithm + " -out " + name + ".key"), 0);
    ASSERT_EQ(openssl("pkey -in " + name + ".key -pubout -out " + name + ".pub"), 0);
  }

  std::filesystem::path folder_, log_;
};

TEST_F(LogSignature, ProvesTheLogByItsKeyAlone) {
  make_key("mine");
  make_key("other");
  const SigningKey mine = SigningKey::read_public(folder_ / "mine.pub");
  EXPECT_THAT(mine.why_not_signed(log_), HasSubstr("there is no signature"));
  SigningKey::read_private(folder_ / "mine.key").sign(log_);
  EXPECT_EQ(mine.why_not_signed(log_), "");
  EXPECT_THAT(SigningKey::read_public(folder_ / "other.pub").why_not_signed(log_),
              HasSubstr("is no signature of this file by this key"));
  EXPECT_EQ(openssl("dgst -sha512 -binary -out digest a.mcap"), 0);
  EXPECT_EQ(openssl("pkeyutl -verify -rawin -pubin -inkey mine.pub -in digest -sigfile "
                    "a.mcap.sig"),
            0);
}

TEST_F(LogSignature, NoticesEachChangeOfTheFile) {
  make_key("mine");
  SigningKey::read_private(folder_ / "mine.key").sign(log_);
  const SigningKey key = SigningKey::read_public(folder_ / "mine.pub");
  const std::string whole = read_file(log_);
  for (const size_t at : {size_t{0}, size_t{1} << 20, whole.size() - 1}) {
    std::string changed = whole;
    changed[at] ^= 1;
    write_file_atomically(log_, changed);
    EXPECT_NE(key.why_not_signed(log_), "") << at;
  }
  write_file_atomically(log_, whole + "x");
  EXPECT_NE(key.why_not_signed(log_), "");
  write_file_atomically(log_, whole);
  EXPECT_EQ(key.why_not_signed(log_), "");
}

TEST_F(LogSignature, TakesEd25519KeysOnly) {
  make_key("x", "x25519");
  make_key("mine");
  EXPECT_THROW(SigningKey::read_private(folder_ / "x.key"), InputError);
  EXPECT_THROW(SigningKey::read_private(folder_ / "mine.pub"), InputError);
  EXPECT_THROW(SigningKey::read_public(folder_ / "mine.key"), InputError);
  EXPECT_THROW(SigningKey::read_public(log_), InputError);
}

}  // namespace
}  // namespace seam::app
