// Why a request is not done; the client gets it as google.rpc.Status.
#pragma once

#include <grpcpp/support/status_code_enum.h>

#include <stdexcept>
#include <string>

namespace seam::tools::dm {

class RequestError : public std::runtime_error {
 public:
  RequestError(grpc::StatusCode code, const std::string& text)
      : std::runtime_error(text), code_(code) {}
  grpc::StatusCode code() const { return code_; }

 private:
  grpc::StatusCode code_;
};

}  // namespace seam::tools::dm
