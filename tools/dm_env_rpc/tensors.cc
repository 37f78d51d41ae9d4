#include "tools/dm_env_rpc/tensors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

using Kind = rpc::Tensor::PayloadCase;

[[noreturn]] void refuse(const std::string& what, const std::string& why,
                         grpc::StatusCode code = grpc::StatusCode::INVALID_ARGUMENT) {
  throw RequestError(code, what + ": " + why);
}

std::string type_name(int type) {
  return rpc::DataType_IsValid(type) ? rpc::DataType_Name(type) : std::to_string(type);
}

size_t elements_in(const rpc::Tensor& tensor) {
  switch (tensor.payload_case()) {
    case Kind::kFloats:
      return static_cast<size_t>(tensor.floats().array_size());
    case Kind::kDoubles:
      return static_cast<size_t>(tensor.doubles().array_size());
    case Kind::kInt8S:
      return tensor.int8s().array().size();
    case Kind::kInt32S:
      return static_cast<size_t>(tensor.int32s().array_size());
    case Kind::kInt64S:
      return static_cast<size_t>(tensor.int64s().array_size());
    case Kind::kUint8S:
      return tensor.uint8s().array().size();
    case Kind::kUint32S:
      return static_cast<size_t>(tensor.uint32s().array_size());
    case Kind::kUint64S:
      return static_cast<size_t>(tensor.uint64s().array_size());
    case Kind::kBools:
      return static_cast<size_t>(tensor.bools().array_size());
    case Kind::kStrings:
      return static_cast<size_t>(tensor.strings().array_size());
    case Kind::kProtos:
      return static_cast<size_t>(tensor.protos().array_size());
    case Kind::PAYLOAD_NOT_SET:
      return 0;
  }
  return 0;
}

std::string shape_text(const google::protobuf::RepeatedField<int32_t>& shape) {
  constexpr int kShown = 8;
  const std::vector<int32_t> first(shape.begin(), shape.begin() + std::min(shape.size(), kShown));
  return fmt::format("[{}{}]", fmt::join(first, ", "), shape.size() > kShown ? ", ..." : "");
}

// The sizes that the shape means for so many elements. Rank and sizes fit the spec, so that no
// client can name a product that overflows.
void check_shape(const rpc::Tensor& tensor, const rpc::TensorSpec& spec, const std::string& what) {
  const auto& shape = tensor.shape();
  const auto misfit = [&](const std::string& why) {
    refuse(what, fmt::format("found shape {}{}, expected {}", shape_text(shape), why,
                             shape_text(spec.shape())));
  };
  if (shape.size() != spec.shape_size()) misfit("");
  const size_t elements = elements_in(tensor);
  size_t known = 1;  // Elements but for the variable dimensions.
  int variable = -1, variable_in_spec = -1;
  for (int i = 0; i < shape.size(); ++i) {
    if (shape[i] < 0 && variable >= 0) misfit(" with two variable dimensions");
    if (shape[i] < 0) variable = i;
    if (spec.shape(i) < 0)
      variable_in_spec = i;
    else if (shape[i] >= 0 && shape[i] != spec.shape(i))
      misfit("");
    else
      known *= static_cast<size_t>(spec.shape(i));
  }
  size_t expected = known;
  if (variable_in_spec >= 0) {
    const int size = shape[variable_in_spec];
    // At most as many as came: a single element does not stand for billions.
    if (known == 0 || elements % known != 0 ||
        (size >= 0 && static_cast<size_t>(size) * known != elements))
      refuse(what, fmt::format("found {} elements for shape {}", elements, shape_text(shape)));
    return;
  }
  if (elements != expected && (elements != 1 || (variable >= 0 && expected != 1)))
    refuse(what, fmt::format("found {} elements, expected {}{}", elements, expected,
                             expected == 1 || variable >= 0 ? "" : ", or 1 that stands for all"));
}

template <class Values, class Bounds>
void check_bounds(const Values& values, const Bounds& min, const Bounds& max,
                  const std::string& what) {
  const auto bound = [](const Bounds& bounds, int i) { return bounds[bounds.size() == 1 ? 0 : i]; };
  for (int i = 0; i < values.size(); ++i) {
    // Said so that no NaN passes.
    if ((min.size() == 0 || values[i] >= bound(min, i)) &&
        (max.size() == 0 || values[i] <= bound(max, i)))
      continue;
    refuse(what,
           fmt::format("found {}, expected {} to {}", values[i], bound(min, i), bound(max, i)),
           grpc::StatusCode::OUT_OF_RANGE);
  }
}

}  // namespace

void check_tensor(const rpc::Tensor& tensor, const rpc::TensorSpec& spec, const std::string& what) {
  // Payloads and types are numbered alike.
  if (static_cast<int>(tensor.payload_case()) != static_cast<int>(spec.dtype()))
    refuse(what, fmt::format("found {}, expected type {}",
                             tensor.payload_case() == Kind::PAYLOAD_NOT_SET
                                 ? "a tensor without values"
                                 : "type " + type_name(tensor.payload_case()),
                             type_name(spec.dtype())));
  check_shape(tensor, spec, what);
  if (tensor.has_doubles())
    check_bounds(tensor.doubles().array(), spec.min().doubles().array(),
                 spec.max().doubles().array(), what);
  if (tensor.has_int32s())
    check_bounds(tensor.int32s().array(), spec.min().int32s().array(), spec.max().int32s().array(),
                 what);
}

int64_t integer_in(const rpc::Tensor& tensor, const std::string& what) {
  if (elements_in(tensor) != 1 || tensor.shape_size() > 0)
    refuse(what, fmt::format("found {} elements of shape {}, expected one integer of shape []",
                             elements_in(tensor), shape_text(tensor.shape())));
  switch (tensor.payload_case()) {
    case Kind::kInt8S:
      return static_cast<signed char>(tensor.int8s().array()[0]);
    case Kind::kInt32S:
      return tensor.int32s().array(0);
    case Kind::kInt64S:
      return tensor.int64s().array(0);
    case Kind::kUint8S:
      return static_cast<unsigned char>(tensor.uint8s().array()[0]);
    case Kind::kUint32S:
      return tensor.uint32s().array(0);
    case Kind::kUint64S:
      if (const uint64_t value = tensor.uint64s().array(0); value <= INT64_MAX)
        return static_cast<int64_t>(value);
      refuse(what, "found a number beyond 2^63 - 1", grpc::StatusCode::OUT_OF_RANGE);
    default:
      refuse(what,
             fmt::format("found type {}, expected an integer", type_name(tensor.payload_case())));
  }
}

std::string text_in(const rpc::Tensor& tensor, const std::string& what) {
  check_tensor(tensor, spec_of("", rpc::STRING), what);
  return tensor.strings().array(0);
}

rpc::Tensor tensor_of(double value) {
  rpc::Tensor tensor;
  tensor.mutable_doubles()->add_array(value);
  return tensor;
}

rpc::Tensor tensor_of(int64_t value) {
  rpc::Tensor tensor;
  tensor.mutable_int64s()->add_array(value);
  return tensor;
}

rpc::Tensor tensor_of(const std::string& text) {
  rpc::Tensor tensor;
  tensor.mutable_strings()->add_array(text);
  return tensor;
}

rpc::Tensor tensor_of(const std::vector<std::string>& texts) {
  rpc::Tensor tensor;
  for (const std::string& text : texts) tensor.mutable_strings()->add_array(text);
  tensor.add_shape(static_cast<int>(texts.size()));
  return tensor;
}

rpc::TensorSpec spec_of(const std::string& name, rpc::DataType type,
                        std::initializer_list<int> shape) {
  rpc::TensorSpec spec;
  spec.set_name(name);
  spec.set_dtype(type);
  for (const int size : shape) spec.add_shape(size);
  return spec;
}

rpc::TensorSpec bounded(const std::string& name, double min, double max) {
  rpc::TensorSpec spec = spec_of(name, rpc::DOUBLE);
  spec.mutable_min()->mutable_doubles()->add_array(min);
  spec.mutable_max()->mutable_doubles()->add_array(max);
  return spec;
}

}  // namespace seam::tools::dm
