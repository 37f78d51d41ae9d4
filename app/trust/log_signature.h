// A signature over a whole log, for logs that are handed in as proof: Ed25519 over the SHA-512 of
// all bytes of the file, 64 bytes in a file beside it, FILE.sig. What a re-run cannot prove (what
// came from outside) the signature binds to whoever holds the key. OpenSSL alone can check it
// (docs/replay.md).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

struct evp_pkey_st;

namespace seam::app {

class SigningKey {
 public:
  // A private key for signing or a public one for checking, PEM. Throws InputError for files that
  // hold no Ed25519 key.
  static SigningKey read_private(const std::filesystem::path& file);
  static SigningKey read_public(const std::filesystem::path& file);

  // Writes the signature beside the log.
  void sign(const std::filesystem::path& log) const;
  // Why the signature beside the log does not prove it; empty where it does.
  std::string why_not_signed(const std::filesystem::path& log) const;

 private:
  struct Free {
    void operator()(evp_pkey_st* key) const;
  };
  explicit SigningKey(evp_pkey_st* key) : key_(key) {}

  std::unique_ptr<evp_pkey_st, Free> key_;
};

// FILE.sig
std::filesystem::path signature_file(const std::filesystem::path& log);

}  // namespace seam::app
