#include "app/trust/tokens.h"

#include <fmt/format.h>
#include <openssl/sha.h>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr std::string_view kPrefix = "fingerprint-";

template <typename Change>
Scenario with_each_token(Scenario scenario, Change change) {
  for (RobotSpec& robot : scenario.robots) change(robot.token);
  change(scenario.supervisor_token);
  change(scenario.render_token);
  return scenario;
}

}  // namespace

std::string token_fingerprint(const std::string& token) {
  if (token.empty() || token.starts_with(kPrefix)) return token;
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), digest);
  return fmt::format("{}{:02x}{:02x}{:02x}{:02x}", kPrefix, digest[0], digest[1], digest[2],
                     digest[3]);
}

Scenario with_fingerprints(Scenario scenario) {
  return with_each_token(std::move(scenario),
                         [](std::string& token) { token = token_fingerprint(token); });
}

Scenario without_fingerprints(Scenario scenario) {
  return with_each_token(std::move(scenario), [](std::string& token) {
    if (token.starts_with(kPrefix)) token.clear();
  });
}

std::string shown_scenario(const std::string& text, const std::string& name) {
  if (text.find("token") == std::string::npos) return text;
  try {
    const Scenario scenario = Scenario::from_text(text, name);
    bool has_tokens = false;
    with_each_token(scenario, [&](const std::string& token) {
      has_tokens |= token != token_fingerprint(token);
    });
    return has_tokens ? with_fingerprints(scenario).to_yaml() : text;
  } catch (const InputError&) {
    return "# The scenario is left out: this program cannot read it, and it may hold tokens.\n";
  }
}

}  // namespace seam::app
