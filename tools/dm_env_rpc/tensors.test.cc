// Tensors by the rules of dm_env_rpc's protocol overview: row-major packing, one variable
// dimension, one element that stands for all, inclusive ranges.
#include "tools/dm_env_rpc/tensors.h"

#include <gtest/gtest.h>

#include <limits>

#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {
namespace {

rpc::Tensor doubles(std::initializer_list<double> values, std::initializer_list<int> shape = {}) {
  rpc::Tensor tensor;
  tensor.mutable_doubles();
  for (const double value : values) tensor.mutable_doubles()->add_array(value);
  for (const int size : shape) tensor.add_shape(size);
  return tensor;
}

void set_range(rpc::TensorSpec& spec, std::initializer_list<double> min,
               std::initializer_list<double> max) {
  for (const double bound : min) spec.mutable_min()->mutable_doubles()->add_array(bound);
  for (const double bound : max) spec.mutable_max()->mutable_doubles()->add_array(bound);
}

// What refuses the tensor, or "" where nothing does.
std::string refusal(const rpc::Tensor& tensor, const rpc::TensorSpec& spec) {
  try {
    check_tensor(tensor, spec, "action 'x'");
  } catch (const RequestError& error) {
    EXPECT_TRUE(error.code() == grpc::StatusCode::INVALID_ARGUMENT ||
                error.code() == grpc::StatusCode::OUT_OF_RANGE);
    const bool range = error.code() == grpc::StatusCode::OUT_OF_RANGE;
    return std::string(range ? "range: " : "argument: ") + error.what();
  }
  return "";
}

rpc::Tensor bytes_of_two() {
  rpc::Tensor tensor;
  tensor.mutable_uint8s()->set_array("12");
  tensor.add_shape(2);
  return tensor;
}

template <class Read>
grpc::StatusCode code_of(Read read) {
  try {
    read();
  } catch (const RequestError& error) {
    return error.code();
  }
  return grpc::StatusCode::OK;
}

TEST(DmTensors, AShapeHasAsManyElementsAsItSays) {
  const rpc::TensorSpec scalar = spec_of("x", rpc::DOUBLE);
  EXPECT_EQ(refusal(doubles({1}), scalar), "");
  EXPECT_EQ(refusal(doubles({}), scalar), "argument: action 'x': found 0 elements, expected 1");
  EXPECT_EQ(refusal(doubles({1, 2}), scalar), "argument: action 'x': found 2 elements, expected 1");
  EXPECT_EQ(refusal(doubles({1}, {1}), scalar),
            "argument: action 'x': found shape [1], expected []");
  const rpc::TensorSpec matrix = spec_of("x", rpc::DOUBLE, {2, 3});
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5, 6}, {2, 3}), matrix), "");
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5, 6}, {3, 2}), matrix),
            "argument: action 'x': found shape [3, 2], expected [2, 3]");
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5, 6}, {6}), matrix),
            "argument: action 'x': found shape [6], expected [2, 3]");
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5}, {2, 3}), matrix),
            "argument: action 'x': found 5 elements, expected 6, or 1 that stands for all");
}

TEST(DmTensors, OneElementStandsForAll) {
  rpc::TensorSpec matrix = spec_of("x", rpc::DOUBLE, {2, 2});
  EXPECT_EQ(refusal(doubles({1}, {2, 2}), matrix), "");
  EXPECT_NE(refusal(doubles({1, 1}, {2, 2}), matrix), "");
  // But not for a number of elements that nobody states.
  EXPECT_NE(refusal(doubles({1}, {2, -1}), matrix), "");
  set_range(matrix, {0}, {1});
  EXPECT_EQ(refusal(doubles({2}, {2, 2}), matrix), "range: action 'x': found 2, expected 0 to 1");
}

TEST(DmTensors, OneDimensionMayBeVariable) {
  const rpc::TensorSpec rows = spec_of("x", rpc::DOUBLE, {2, -1});
  for (const int columns : {-1, 3})
    EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5, 6}, {2, columns}), rows), "");
  EXPECT_EQ(refusal(doubles({}, {2, -1}), rows), "");
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4, 5}, {2, -1}), rows),
            "argument: action 'x': found 5 elements for shape [2, -1]");
  EXPECT_NE(refusal(doubles({1, 2, 3, 4, 5, 6}, {2, 4}), rows), "");
  EXPECT_NE(refusal(doubles({1, 2, 3, 4, 5, 6}, {3, -1}), rows), "");
  EXPECT_EQ(refusal(doubles({1, 2}, {-1, -1}), spec_of("x", rpc::DOUBLE, {2, 1})),
            "argument: action 'x': found shape [-1, -1] with two variable dimensions, expected "
            "[2, 1]");
  // Of a spec without one the sender's is inferred.
  EXPECT_EQ(refusal(doubles({1, 2, 3, 4}, {2, -1}), spec_of("x", rpc::DOUBLE, {2, 2})), "");
  EXPECT_NE(refusal(doubles({1, 2, 3, 4, 5, 6}, {2, -1}), spec_of("x", rpc::DOUBLE, {2, 2})), "");
}

TEST(DmTensors, RangesAreInclusiveAndOneOrOneForEachElement) {
  rpc::TensorSpec spec = spec_of("x", rpc::DOUBLE, {2});
  set_range(spec, {-1}, {2});
  EXPECT_EQ(refusal(doubles({-1, 2}, {2}), spec), "");
  EXPECT_EQ(refusal(doubles({0, 2.5}, {2}), spec),
            "range: action 'x': found 2.5, expected -1 to 2");
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()})
    EXPECT_TRUE(refusal(doubles({0, value}, {2}), spec).starts_with("range: ")) << value;
  rpc::TensorSpec each = spec_of("x", rpc::DOUBLE, {2});
  set_range(each, {0, 10}, {1, 11});
  EXPECT_EQ(refusal(doubles({1, 10}, {2}), each), "");
  EXPECT_EQ(refusal(doubles({1, 1}, {2}), each), "range: action 'x': found 1, expected 10 to 11");
  rpc::TensorSpec whole = spec_of("x", rpc::INT32);
  whole.mutable_min()->mutable_int32s()->add_array(0);
  whole.mutable_max()->mutable_int32s()->add_array(7);
  rpc::Tensor kick;
  kick.mutable_int32s()->add_array(7);
  EXPECT_EQ(refusal(kick, whole), "");
  kick.mutable_int32s()->set_array(0, -1);
  EXPECT_EQ(refusal(kick, whole), "range: action 'x': found -1, expected 0 to 7");
}

TEST(DmTensors, TypesAreThoseOfTheSpec) {
  rpc::Tensor integer = tensor_of(int64_t{3});
  EXPECT_EQ(refusal(integer, spec_of("x", rpc::DOUBLE)),
            "argument: action 'x': found type INT64, expected type DOUBLE");
  EXPECT_EQ(refusal(rpc::Tensor(), spec_of("x", rpc::DOUBLE)),
            "argument: action 'x': found a tensor without values, expected type DOUBLE");
  rpc::Tensor bytes;  // Of 8 bits an element is a byte of the payload.
  bytes.mutable_uint8s()->set_array(std::string("\0\1\2", 3));
  bytes.add_shape(3);
  EXPECT_EQ(refusal(bytes, spec_of("x", rpc::UINT8, {-1})), "");
  EXPECT_NE(refusal(bytes, spec_of("x", rpc::INT8, {-1})), "");
}

TEST(DmTensors, SettingsAreIntegersOfAnyTypeAndTexts) {
  EXPECT_EQ(integer_in(tensor_of(int64_t{-7}), "seed"), -7);
  rpc::Tensor tensor;
  tensor.mutable_int8s()->set_array("\xff");
  EXPECT_EQ(integer_in(tensor, "seed"), -1);
  tensor.mutable_uint8s()->set_array("\xff");
  EXPECT_EQ(integer_in(tensor, "seed"), 255);
  tensor.mutable_uint32s()->add_array(4'000'000'000u);
  EXPECT_EQ(integer_in(tensor, "seed"), 4'000'000'000);
  tensor.mutable_uint64s()->add_array(uint64_t{1} << 63);
  EXPECT_EQ(code_of([&] { integer_in(tensor, "seed"); }), grpc::StatusCode::OUT_OF_RANGE);
  for (const rpc::Tensor& other : {tensor_of(1.0), tensor_of("7"), rpc::Tensor(), bytes_of_two()})
    EXPECT_EQ(code_of([&] { integer_in(other, "seed"); }), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(text_in(tensor_of("red1"), "robot"), "red1");
  for (const rpc::Tensor& other : {tensor_of(1.0), tensor_of(std::vector<std::string>{"red1"})})
    EXPECT_EQ(code_of([&] { text_in(other, "robot"); }), grpc::StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace seam::tools::dm
