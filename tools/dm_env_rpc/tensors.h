// Tensors of dm_env_rpc: checked against their specs, read and made.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "dm_env_rpc/v1/dm_env_rpc.pb.h"

namespace seam::tools::dm {

namespace rpc = ::dm_env_rpc::v1;

// Throws RequestError unless the tensor has the spec's type and shape, one element or as many as
// the shape has, and all of them within the bounds. `what` it is: "action 'kick'".
void check_tensor(const rpc::Tensor& tensor, const rpc::TensorSpec& spec, const std::string& what);

// Of a tensor that holds one integer of any type. Throws RequestError.
int64_t integer_in(const rpc::Tensor& tensor, const std::string& what);
// Of one that holds one text.
std::string text_in(const rpc::Tensor& tensor, const std::string& what);

rpc::Tensor tensor_of(double value);
rpc::Tensor tensor_of(int64_t value);
rpc::Tensor tensor_of(const std::string& text);
rpc::Tensor tensor_of(const std::vector<std::string>& texts);

rpc::TensorSpec spec_of(const std::string& name, rpc::DataType type,
                        std::initializer_list<int> shape = {});
// With bounds, of type DOUBLE.
rpc::TensorSpec bounded(const std::string& name, double min, double max);

}  // namespace seam::tools::dm
