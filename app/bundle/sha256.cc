#include "app/bundle/sha256.h"

#include <openssl/evp.h>

#include "sim_core/base/error.h"

namespace seam::app {

void Sha256::Free::operator()(evp_md_ctx_st* context) const {
  EVP_MD_CTX_free(context);
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  SEAM_CHECK(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1,
             "no SHA-256");
}

void Sha256::add(std::string_view bytes) {
  SEAM_CHECK(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1, "no SHA-256");
}

std::string Sha256::digest() {
  unsigned char bytes[EVP_MAX_MD_SIZE];
  unsigned count = 0;
  SEAM_CHECK(EVP_DigestFinal_ex(context_.get(), bytes, &count) == 1, "no SHA-256");
  std::string text;
  for (unsigned i = 0; i < count; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

}  // namespace seam::app
