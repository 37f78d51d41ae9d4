#include "app/trust/log_signature.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <algorithm>

#include "mcap/io.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::app {
namespace {

constexpr uint64_t kMaxKeyBytes = 16 << 10;
constexpr uint64_t kBlockBytes = 1 << 20;
constexpr size_t kSignatureBytes = 64;

struct FreeContext {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using Context = std::unique_ptr<EVP_MD_CTX, FreeContext>;

struct FreeBio {
  void operator()(BIO* bio) const { BIO_free(bio); }
};

const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

// Blocks of a file: logs may be larger than memory.
std::string sha512_of(const std::filesystem::path& file) {
  const std::unique_ptr<mcap::Input> input = mcap::open_file(file);
  const Context context(EVP_MD_CTX_new());
  SEAM_CHECK(EVP_DigestInit_ex(context.get(), EVP_sha512(), nullptr) == 1, "SHA-512");
  for (uint64_t at = 0; at < input->size(); at += kBlockBytes) {
    const std::string block = input->read(at, std::min(kBlockBytes, input->size() - at));
    SEAM_CHECK(EVP_DigestUpdate(context.get(), block.data(), block.size()) == 1, "SHA-512");
  }
  std::string digest(EVP_MAX_MD_SIZE, '\0');
  unsigned int size = 0;
  SEAM_CHECK(EVP_DigestFinal_ex(context.get(), reinterpret_cast<unsigned char*>(digest.data()),
                                &size) == 1,
             "SHA-512");
  digest.resize(size);
  return digest;
}

template <typename Read>
EVP_PKEY* read_key(const std::filesystem::path& file, const char* kind, Read read) {
  const std::string pem = read_file(file, kMaxKeyBytes);
  const std::unique_ptr<BIO, FreeBio> bio(
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  // A key with a password would ask for it at the terminal; such keys are refused instead.
  EVP_PKEY* key = read(
      bio.get(), nullptr, [](char*, int, int, void*) { return -1; }, nullptr);
  if (key == nullptr || EVP_PKEY_id(key) != EVP_PKEY_ED25519) {
    EVP_PKEY_free(key);
    throw InputError(
        fmt::format("{}: expected {} Ed25519 key in PEM, without a password", file.string(), kind));
  }
  return key;
}

}  // namespace

void SigningKey::Free::operator()(evp_pkey_st* key) const {
  EVP_PKEY_free(key);
}

SigningKey SigningKey::read_private(const std::filesystem::path& file) {
  return SigningKey(read_key(file, "a private", PEM_read_bio_PrivateKey));
}

SigningKey SigningKey::read_public(const std::filesystem::path& file) {
  return SigningKey(read_key(file, "a public", PEM_read_bio_PUBKEY));
}

void SigningKey::sign(const std::filesystem::path& log) const {
  const std::string digest = sha512_of(log);
  const Context context(EVP_MD_CTX_new());
  std::string signature(kSignatureBytes, '\0');
  size_t size = signature.size();
  SEAM_CHECK(EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key_.get()) == 1 &&
                 EVP_DigestSign(context.get(), reinterpret_cast<unsigned char*>(signature.data()),
                                &size, bytes_of(digest), digest.size()) == 1,
             "Ed25519");
  write_file_atomically(signature_file(log), signature);
}

std::string SigningKey::why_not_signed(const std::filesystem::path& log) const {
  const std::filesystem::path file = signature_file(log);
  if (!std::filesystem::exists(file)) return fmt::format("there is no signature {}", file.string());
  const std::string signature = read_file(file, kMaxKeyBytes);
  if (signature.size() != kSignatureBytes) {
    return fmt::format("{}: found {} bytes, expected {}", file.string(), signature.size(),
                       kSignatureBytes);
  }
  const std::string digest = sha512_of(log);
  const Context context(EVP_MD_CTX_new());
  SEAM_CHECK(EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key_.get()) == 1,
             "Ed25519");
  const bool right = EVP_DigestVerify(context.get(), bytes_of(signature), signature.size(),
                                      bytes_of(digest), digest.size()) == 1;
  return right ? "" : fmt::format("{} is no signature of this file by this key", file.string());
}

std::filesystem::path signature_file(const std::filesystem::path& log) {
  return log.string() + ".sig";
}

}  // namespace seam::app
