#include "tools/pages/loopback_host.h"

#include <gtest/gtest.h>

namespace seam::tools {
namespace {

TEST(LoopbackHost, TakesLoopbackNamesOnly) {
  for (const char* host : {"localhost", "localhost:8080", "LocalHost:1", "127.0.0.1",
                           "127.0.0.1:65535", "[::1]", "[::1]:8080"})
    EXPECT_TRUE(names_loopback(host)) << host;
  for (const char* host :
       {"", "evil.example", "localhost.evil.example", "localhost.evil.example:80", "localhost:",
        "localhost:80.evil.example", "127.0.0.1.evil.example", "127.0.0.1:80@evil.example",
        "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:99999999999999999999", "127.0.0.2:80",
        "::1:80", "[::1]x", "[::1]:80 ", " localhost:80", "0.0.0.0:80", "evil.example:80"})
    EXPECT_FALSE(names_loopback(host)) << host;
}

}  // namespace
}  // namespace seam::tools
