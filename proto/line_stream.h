// A direct line as its client has it: reads and writes like a gRPC stream.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "proto/line.h"
#include "seam/v1/simulation.pb.h"

namespace seam {

class LineStream {
 public:
  // Connects to the Unix socket at `path`; where that fails, reading and writing do.
  explicit LineStream(const std::string& path);
  ~LineStream();
  LineStream(const LineStream&) = delete;
  LineStream& operator=(const LineStream&) = delete;

  bool Write(const v1::ClientMessage& message);
  // False at the end.
  bool Read(v1::ServerMessage* message);
  void WritesDone() {}
  // Why it ended.
  grpc::Status Finish() const { return status_; }

 private:
  bool break_off(const char* why);

  int socket_ = -1;
  LineFrames incoming_;
  grpc::Status status_;
};

}  // namespace seam
