// Linked into every program of the ThreadSanitizer build. gRPC, Abseil, Protocol Buffers and
// OpenSSL come from Debian without its instrumentation, so the sanitizer does not see how they hand
// data from thread to thread.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:libgpr\n"
         "race:libgrpc\n"
         "race:libabsl\n"
         "race:libprotobuf\n"
         "race:grpc::\n"
         "race:grpc_core::\n"
         "race:google::protobuf\n"
         "race:libssl\n"
         "race:libcrypto\n";
}
