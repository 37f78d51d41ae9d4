// `seam certs DIR`: a test set of certificates for TLS.
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <filesystem>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {

namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;

struct Identity {
  Key key{nullptr, EVP_PKEY_free};
  Certificate certificate{nullptr, X509_free};
};

void require(bool good, const char* what) {
  if (!good) throw InputError(fmt::format("certificates: OpenSSL cannot {}", what));
}

void add_extension(X509& certificate, X509& issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &issuer, &certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_nconf_nid(nullptr, &context, kind, value.c_str());
  require(extension != nullptr, ("add the extension " + value).c_str());
  X509_add_ext(&certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

// Signed by `issuer`, or by itself where there is none.
Identity make_identity(const std::string& name, const Identity* issuer, const std::string& usage,
                       const std::string& hosts, int days) {
  Identity made;
  made.key.reset(EVP_EC_gen("P-256"));
  made.certificate.reset(X509_new());
  require(made.key && made.certificate, "make a key");
  X509& certificate = *made.certificate;
  X509_set_version(&certificate, 2);
  ASN1_STRING* serial = ASN1_INTEGER_new();
  BIGNUM* number = BN_new();
  BN_rand(number, 127, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY);
  BN_to_ASN1_INTEGER(number, serial);
  X509_set_serialNumber(&certificate, serial);
  BN_free(number);
  ASN1_INTEGER_free(serial);
  X509_gmtime_adj(X509_getm_notBefore(&certificate), -3600);  // Clocks of machines differ.
  X509_time_adj_ex(X509_getm_notAfter(&certificate), days, 0, nullptr);
  X509_set_pubkey(&certificate, made.key.get());
  X509_NAME* subject = X509_get_subject_name(&certificate);
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509& signer = issuer != nullptr ? *issuer->certificate : certificate;
  X509_set_issuer_name(&certificate, X509_get_subject_name(&signer));
  const bool is_ca = issuer == nullptr;
  add_extension(certificate, signer, NID_basic_constraints,
                is_ca ? "critical,CA:TRUE" : "CA:FALSE");
  add_extension(certificate, signer, NID_key_usage,
                is_ca ? "critical,keyCertSign,cRLSign" : "critical,digitalSignature");
  if (!usage.empty()) add_extension(certificate, signer, NID_ext_key_usage, usage);
  if (!hosts.empty()) add_extension(certificate, signer, NID_subject_alt_name, hosts);
  EVP_PKEY* signing_key = issuer != nullptr ? issuer->key.get() : made.key.get();
  require(X509_sign(&certificate, signing_key, EVP_sha256()) > 0, "sign a certificate");
  return made;
}

template <class Write>
std::string pem_text(Write write) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> memory(BIO_new(BIO_s_mem()), BIO_free);
  require(memory && write(memory.get()) == 1, "write PEM");
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &bytes);
  return {bytes, static_cast<size_t>(size)};
}

void write_identity(const std::filesystem::path& folder, const std::string& name,
                    const Identity& identity) {
  write_file_atomically(folder / (name + ".pem"), pem_text([&](BIO* out) {
                          return PEM_write_bio_X509(out, identity.certificate.get());
                        }));
  OutputFile(folder / (name + ".key"), {.inputs = {}, .mode = S_IRUSR | S_IWUSR})
      .fill(pem_text([&](BIO* out) {
        return PEM_write_bio_PrivateKey(out, identity.key.get(), nullptr, nullptr, 0, nullptr,
                                        nullptr);
      }));
}

// "DNS:localhost,IP:127.0.0.1,..." with what the user named.
std::string alternative_names(const std::vector<std::string>& hosts) {
  std::string names = "DNS:localhost,IP:127.0.0.1,IP:::1";
  for (const std::string& host : hosts) {
    ASN1_OCTET_STRING* address = a2i_IPADDRESS(host.c_str());
    names += (address != nullptr ? ",IP:" : ",DNS:") + host;
    ASN1_OCTET_STRING_free(address);
  }
  return names;
}

}  // namespace

void add_certs(app::Command app) {
  struct Options {
    std::string folder;
    std::vector<std::string> hosts;
    int days = 365;
  };
  auto options = std::make_shared<Options>();
  app::Command command = app.add_subcommand(
      "certs", "Makes a test set of certificates: a CA, a server's and a client's");
  command.add_option("DIR", options->folder, "Where ca, server, client .pem and .key go")
      .required();
  command.add_option(
      "--host", options->hosts,
      "A name or address of the server beside localhost; may be given several times");
  command.add_option("--days", options->days, "How long they are good")
      .range(1, 3650)
      .show_default();
  command.footer("Example:\n  seam certs certs --host 10.0.0.1");
  command.callback([options] {
    make_output_folder(options->folder);
    const Identity ca = make_identity("SEAM test CA", nullptr, "", "", options->days);
    write_identity(options->folder, "ca", ca);
    write_identity(options->folder, "server",
                   make_identity("SEAM test server", &ca, "serverAuth",
                                 alternative_names(options->hosts), options->days));
    write_identity(options->folder, "client",
                   make_identity("SEAM test client", &ca, "clientAuth", "", options->days));
    std::printf("%s: ca, server and client certificates for %d days\n", options->folder.c_str(),
                options->days);
  });
}

}  // namespace seam::tools
