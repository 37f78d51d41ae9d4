#include "render/assets/gltf_limits.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "render/assets/assets.h"
#include "sim_core/base/error.h"
#include "sim_core/input/json_input.h"

namespace seam::render {
namespace {

using nlohmann::json;

constexpr uint64_t kMostCorners = 3 * uint64_t{kMostTriangles};
constexpr uint64_t kMostNodes = 100'000;
constexpr uint64_t kFar = uint64_t{1} << 40;  // Sums stay below 2^63.

std::string json_chunk(const std::string& bytes) {
  constexpr size_t kHeader = 20;  // Of the file 12, of the first chunk 8.
  if (!bytes.starts_with("glTF")) return bytes;
  uint32_t length = 0;
  if (bytes.size() < kHeader) return "";
  std::memcpy(&length, &bytes[12], sizeof length);
  return bytes.substr(kHeader, length);
}

const json& list_of(const json& object, const char* key) {
  static const json kNone = json::array();
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : kNone;
}
uint64_t number_of(const json& object, const char* key, uint64_t otherwise) {
  if (!object.is_object()) return otherwise;
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<uint64_t>() : otherwise;
}

// What a node and all below it unpack to.
struct Amount {
  uint64_t nodes = 0, vertices = 0;
  void add(const Amount& other) {
    nodes = std::min(kFar, nodes + other.nodes);
    vertices = std::min(kFar, vertices + other.vertices);
  }
};

class Counter {
 public:
  explicit Counter(const json& root)
      : nodes_(list_of(root, "nodes")),
        accessors_(list_of(root, "accessors")),
        meshes_(vertices_of_meshes(list_of(root, "meshes"))),
        state_(nodes_.size()),
        amounts_(nodes_.size()) {}

  // All of them, whether a scene shows them or not: readers unpack meshes that no node names, too.
  void check() {
    Amount all;
    for (const uint64_t vertices : meshes_) all.add({0, vertices});
    check(all);
    std::vector<bool> is_child(nodes_.size());
    for (const json& node : nodes_)
      for (const json& child : list_of(node, "children"))
        if (child.is_number_unsigned() && child.get<uint64_t>() < is_child.size())
          is_child[child.get<uint64_t>()] = true;
    for (size_t i = 0; i < nodes_.size(); ++i) count(i);
    all = {};
    for (size_t i = 0; i < nodes_.size(); ++i)
      if (!is_child[i]) all.add(amounts_[i]);
    check(all);
  }

 private:
  enum class State : uint8_t { unseen, open, counted };

  uint64_t values_of(uint64_t accessor) const {
    return accessor < accessors_.size()
               ? std::min(kFar, number_of(accessors_[accessor], "count", 0))
               : 0;
  }
  // Corners of triangles, or values that are unpacked for them: whichever is more.
  std::vector<uint64_t> vertices_of_meshes(const json& meshes) const {
    std::vector<uint64_t> counts;
    for (const json& mesh : meshes) {
      uint64_t sum = 0;
      for (const json& primitive : list_of(mesh, "primitives")) {
        uint64_t most =
            primitive.is_object() ? values_of(number_of(primitive, "indices", kFar)) : 0;
        const auto add_all = [&](const json& attributes) {
          if (!attributes.is_object()) return;
          for (const json& attribute : attributes)
            if (attribute.is_number_unsigned())
              most = std::max(most, values_of(attribute.get<uint64_t>()));
        };
        if (primitive.is_object() && primitive.contains("attributes"))
          add_all(primitive["attributes"]);
        uint64_t copies = 1;
        for (const json& target : list_of(primitive, "targets")) add_all(target), ++copies;
        sum = std::min(kFar, sum + copies * std::min(most, kFar / copies));
      }
      counts.push_back(sum);
    }
    return counts;
  }

  // Without recursion: a chain of nodes may be as long as the file.
  void count(size_t root) {
    std::vector<size_t> way{root};
    while (!way.empty()) {
      const size_t at = way.back();
      if (state_[at] == State::counted) {
        way.pop_back();
        continue;
      }
      const json& children = list_of(nodes_[at], "children");
      if (state_[at] == State::unseen) {
        state_[at] = State::open;
        for (const json& child : children) push(child, way);
        continue;
      }
      const uint64_t mesh = number_of(nodes_[at], "mesh", kFar);
      amounts_[at] = {1, mesh < meshes_.size() ? meshes_[mesh] : 0};
      for (const json& child : children)
        if (child.is_number_unsigned() && child.get<uint64_t>() < nodes_.size())
          amounts_[at].add(amounts_[child.get<uint64_t>()]);
      state_[at] = State::counted;
      way.pop_back();
    }
  }
  void push(const json& child, std::vector<size_t>& way) const {
    if (!child.is_number_unsigned() || child.get<uint64_t>() >= nodes_.size()) return;
    const size_t place = child.get<uint64_t>();
    if (state_[place] == State::open)
      throw InputError(
          fmt::format("nodes[{}] is a child of itself, expected children in no circle", place));
    if (state_[place] == State::unseen) way.push_back(place);
  }

  static void check(const Amount& amount) {
    if (amount.vertices > kMostCorners)
      throw InputError(fmt::format(
          "its meshes, each as often as nodes name it, hold {} vertices, expected at most {}",
          amount.vertices, kMostCorners));
    if (amount.nodes > kMostNodes)
      throw InputError(
          fmt::format("its nodes, each as often as others name it as a child, are {}, expected at "
                      "most {}: give each node one parent",
                      amount.nodes, kMostNodes));
  }

  const json& nodes_;
  const json& accessors_;
  const std::vector<uint64_t> meshes_;  // Vertices of each.
  std::vector<State> state_;
  std::vector<Amount> amounts_;
};

}  // namespace

void check_gltf(const std::string& bytes) {
  const std::string text = json_chunk(bytes);
  json root;
  try {
    root = json_from_text(text, "it", "glTF 2.0");
  } catch (const InputError& error) {
    throw InputError(fmt::format("not a readable mesh: {}", error.what()));
  }
  Counter(root).check();
}

}  // namespace seam::render
