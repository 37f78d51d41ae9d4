#include "sim_core/input/config_table.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/shown_text.h"

namespace seam {
namespace {

// Scenarios share models and robots with their neighbours, so that `..` and absolute paths are well
// here.
std::filesystem::path beside(const ConfigNode& node, const std::string& path) {
  if (path.empty() || shown(path) != path)
    node.fail(fmt::format("found '{}', expected the path of a file", shown(path)));
  const std::filesystem::path file(path);
  return file.is_absolute() ? file : std::filesystem::path(node.file()).parent_path() / file;
}

class Reader final : public ConfigTable {
 public:
  explicit Reader(ConfigNode node) : node_(std::move(node)) {}

  void format(const char* expected) override {
    const auto found = node_.find("format");
    if (found && found->text() != expected) {
      found->fail(fmt::format("found '{}', expected '{}'", found->text(), expected));
    }
  }
  void number(ConfigKey key, double& value, Range range) override {
    if (const auto found = find(key)) value = found->number(range);
  }
  void integer(ConfigKey key, int64_t& value, int64_t min, int64_t max) override {
    if (const auto found = find(key)) value = found->integer(min, max);
  }
  void boolean(ConfigKey key, bool& value) override {
    if (const auto found = find(key)) value = found->boolean();
  }
  void text(ConfigKey key, std::string& value) override {
    if (const auto found = find(key)) value = found->text();
  }
  void texts(ConfigKey key, std::vector<std::string>& value) override {
    const auto found = find(key);
    if (!found) return;
    value.clear();
    for (const ConfigNode& item : found->items()) value.push_back(item.text());
  }
  void numbers(ConfigKey key, std::span<double> value) override {
    const auto found = find(key);
    if (!found) return;
    const auto read = found->numbers(value.size());
    std::copy(read.begin(), read.end(), value.begin());
  }
  void sizes(ConfigKey key, Vec3& value, size_t count) override {
    numbers(key, std::span<double>(&value.x, count));
    for (size_t i = 0; i < count; ++i) {
      require((&value.x)[i] > 0, key.key,
              fmt::format("expected {} lengths of more than 0 metres", count));
    }
  }
  void choice(ConfigKey key, size_t& value, const std::vector<std::string>& words) override {
    if (const auto found = find(key)) value = found->choice(words);
  }
  void object(ConfigKey key, const Describe& describe) override {
    if (const auto found = find(key)) read_config(*found, describe);
  }
  void file_or_object(ConfigKey key, const Describe& describe) override {
    const auto found = find(key);
    if (!found) return;
    if (found->is_scalar()) {
      read_config(open(*found), describe);
    } else {
      read_config(*found, describe);
    }
  }
  void file_or_yaml(ConfigKey key, std::string& yaml, std::string& name) override {
    const auto found = find(key);
    if (!found) return;
    name = found->is_scalar() ? beside(*found, found->text()).lexically_normal().string()
                              : found->where();
    const ConfigNode content = found->is_scalar() ? open(*found) : *found;
    YAML::Emitter out;
    out.SetDoublePrecision(17);
    out << content.yaml();
    yaml = out.c_str();
  }
  void file_name(ConfigKey key, FileName& value) override {
    const auto found = find(key);
    if (!found) return;
    if (found->is_scalar()) {
      const std::filesystem::path file(found->file());
      value = {found->text(), std::filesystem::absolute(file).parent_path().string(), ""};
    } else {
      value = {found->at("name").text(), found->at("folder").text(),
               found->text_or("fingerprint", "")};
      found->finish();
    }
    const std::string why = why_not_inside(value.folder, value.name);
    if (!why.empty()) found->fail(why);
  }
  void list(ConfigKey key, size_t, size_t limit, const std::function<void(size_t)>& resize,
            const std::function<void(ConfigTable&, size_t)>& describe_item) override {
    const auto found = find(key);
    if (!found) return;
    const auto items = found->items();
    if (items.size() > limit) {
      found->fail(fmt::format("found {} entries, expected at most {}", items.size(), limit));
    }
    resize(items.size());
    for (size_t i = 0; i < items.size(); ++i) {
      read_config(items[i], [&](ConfigTable& table) { describe_item(table, i); });
    }
  }
  void require(bool condition, const char* key, const std::string& message) override {
    if (condition) return;
    const auto found = node_.find(key);
    (found ? *found : node_).fail(message);
  }
  void texts_by_name(ConfigKey key, std::map<std::string, std::string>& value) override {
    const auto found = find(key);
    if (!found) return;
    for (const std::string& name : found->keys()) value[name] = found->at(name).text();
  }
  void numbers_by_name(ConfigKey key, std::map<std::string, double>& value, Range range) override {
    const auto found = find(key);
    if (!found || !found->is_map()) return;  // A word in its place says that nothing is known.
    for (const std::string& name : found->keys()) {
      if (const auto number = found->find(name)) value[name] = number->number(range);
    }
  }
  void elsewhere(ConfigKey key, const Describe&) override { find(key); }
  void allow_notes() override { has_notes_ = true; }
  void finish() const { has_notes_ ? node_.finish_with_notes() : node_.finish(); }

 private:
  std::optional<ConfigNode> find(const ConfigKey& key) const {
    return key.required ? std::optional(node_.at(key.key)) : node_.find(key.key);
  }
  static ConfigNode open(const ConfigNode& path) {
    try {
      return ConfigNode::from_file(beside(path, path.text()));
    } catch (const InputError& error) {
      path.fail(error.what());
    }
  }

  ConfigNode node_;
  bool has_notes_ = false;
};

class Writer final : public ConfigTable {
 public:
  explicit Writer(YAML::Emitter& out) : out_(out) { out_ << YAML::BeginMap; }
  bool writes() const override { return true; }
  ~Writer() override { out_ << YAML::EndMap; }

  void format(const char* expected) override {
    out_ << YAML::Key << "format" << YAML::Value << expected;
  }
  void number(ConfigKey key, double& value, Range) override {
    put(key) << fmt::format("{}", value);
  }
  void integer(ConfigKey key, int64_t& value, int64_t, int64_t) override { put(key) << value; }
  void boolean(ConfigKey key, bool& value) override { put(key) << value; }
  void text(ConfigKey key, std::string& value) override { put(key) << YAML::DoubleQuoted << value; }
  void texts(ConfigKey key, std::vector<std::string>& value) override {
    put(key) << YAML::Flow << YAML::BeginSeq;
    for (const std::string& item : value) out_ << YAML::DoubleQuoted << item;
    out_ << YAML::EndSeq;
  }
  void numbers(ConfigKey key, std::span<double> value) override {
    put(key) << YAML::Flow << YAML::BeginSeq;
    for (const double item : value) out_ << fmt::format("{}", item);
    out_ << YAML::EndSeq;
  }
  void sizes(ConfigKey key, Vec3& value, size_t count) override {
    numbers(key, std::span<double>(&value.x, count));
  }
  void choice(ConfigKey key, size_t& value, const std::vector<std::string>& words) override {
    put(key) << words.at(value);
  }
  void object(ConfigKey key, const Describe& describe) override {
    put(key);
    Writer inner(out_);
    describe(inner);
  }
  void file_or_object(ConfigKey key, const Describe& describe) override { object(key, describe); }
  void file_or_yaml(ConfigKey key, std::string& yaml, std::string&) override {
    if (!yaml.empty()) put(key) << YAML::Load(yaml);
  }
  void file_name(ConfigKey key, FileName& value) override {
    if (value.name.empty()) return;
    put(key) << YAML::Flow << YAML::BeginMap;
    const std::pair<const char*, const std::string&> items[] = {
        {"name", value.name}, {"folder", value.folder}, {"fingerprint", value.fingerprint}};
    for (const auto& [name, text] : items)
      out_ << YAML::Key << name << YAML::Value << YAML::DoubleQuoted << text;
    out_ << YAML::EndMap;
  }
  void list(ConfigKey key, size_t count, size_t, const std::function<void(size_t)>&,
            const std::function<void(ConfigTable&, size_t)>& describe_item) override {
    put(key) << YAML::BeginSeq;
    for (size_t i = 0; i < count; ++i) {
      Writer inner(out_);
      describe_item(inner, i);
    }
    out_ << YAML::EndSeq;
  }
  void texts_by_name(ConfigKey key, std::map<std::string, std::string>& value) override {
    put(key) << YAML::BeginMap;
    for (const auto& [name, text] : value)
      out_ << YAML::Key << name << YAML::Value << YAML::DoubleQuoted << text;
    out_ << YAML::EndMap;
  }
  void numbers_by_name(ConfigKey key, std::map<std::string, double>& value, Range) override {
    put(key) << YAML::BeginMap;
    for (const auto& [name, number] : value)
      out_ << YAML::Key << name << YAML::Value << fmt::format("{}", number);
    out_ << YAML::EndMap;
  }
  void elsewhere(ConfigKey, const Describe&) override {}
  void require(bool, const char*, const std::string&) override {}

 private:
  YAML::Emitter& put(const ConfigKey& key) { return out_ << YAML::Key << key.key << YAML::Value; }
  YAML::Emitter& out_;
};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

// Collects the properties of one object; nested ones are written depth first.
class Schema final : public ConfigTable {
 public:
  explicit Schema(int depth) : indent_(static_cast<size_t>(depth) * 2, ' '), depth_(depth) {}

  void format(const char* expected) override {
    std::string body = fmt::format("\"const\": {}", quoted(expected));
    add({"format", "What kind of file this is."}, body);
  }
  void number(ConfigKey key, double&, Range range) override {
    std::string body = R"("type": "number")";
    if (std::isfinite(range.min)) body += fmt::format(R"(, "minimum": {})", range.min);
    if (std::isfinite(range.max)) body += fmt::format(R"(, "maximum": {})", range.max);
    add(key, body);
  }
  void integer(ConfigKey key, int64_t&, int64_t min, int64_t max) override {
    add(key, fmt::format(R"("type": "integer", "minimum": {}, "maximum": {})", min, max));
  }
  void boolean(ConfigKey key, bool&) override { add(key, R"("type": "boolean")"); }
  void text(ConfigKey key, std::string&) override { add(key, R"("type": "string")"); }
  void texts(ConfigKey key, std::vector<std::string>&) override {
    add(key, R"("type": "array", "items": {"type": ["string", "number"]})");
  }
  void numbers(ConfigKey key, std::span<double> value) override {
    add(key,
        fmt::format(
            R"("type": "array", "items": {{"type": "number"}}, "minItems": {0}, "maxItems": {0})",
            value.size()));
  }
  void sizes(ConfigKey key, Vec3&, size_t) override {
    add(key,
        R"("type": "array", "items": {"type": "number", "exclusiveMinimum": 0}, "minItems": 2, "maxItems": 3)");
  }
  bool names_alternatives() const override { return true; }
  void choice(ConfigKey key, size_t&, const std::vector<std::string>& words) override {
    std::string list;
    for (const std::string& word : words) list += (list.empty() ? "" : ", ") + quoted(word);
    add(key, fmt::format(R"("enum": [{}])", list));
  }
  void object(ConfigKey key, const Describe& describe) override {
    add(key, object_body(describe, 1));
  }
  void file_or_object(ConfigKey key, const Describe& describe) override {
    add(key, fmt::format("\"anyOf\": [{{\"type\": \"string\"}},\n{}    {{{}}}]", indent_,
                         object_body(describe, 2)));
  }
  void file_or_yaml(ConfigKey key, std::string&, std::string&) override {
    add(key, R"("type": ["string", "object"])");
  }
  void file_name(ConfigKey key, FileName&) override { add(key, R"("type": ["string", "object"])"); }
  void list(ConfigKey key, size_t, size_t limit, const std::function<void(size_t)>& resize,
            const std::function<void(ConfigTable&, size_t)>& describe_item) override {
    resize(1);
    add(key, fmt::format("\"type\": \"array\", \"maxItems\": {}, \"items\": {{{}}}", limit,
                         object_body([&](ConfigTable& table) { describe_item(table, 0); }, 1)));
  }
  void texts_by_name(ConfigKey key, std::map<std::string, std::string>&) override {
    add(key, R"("type": "object", "additionalProperties": {"type": "string"})");
  }
  void numbers_by_name(ConfigKey key, std::map<std::string, double>&, Range range) override {
    add(key, fmt::format(R"("type": ["object", "string", "null"], "additionalProperties": )"
                         R"({{"type": ["number", "null"], "minimum": {}, "maximum": {}}})",
                         range.min, range.max));
  }
  void elsewhere(ConfigKey key, const Describe& describe) override { object(key, describe); }
  void allow_notes() override { has_notes_ = true; }
  void require(bool, const char*, const std::string&) override {}

  std::string body() const {
    std::string out = fmt::format("\"type\": \"object\", \"additionalProperties\": {}", has_notes_);
    if (!required_.empty()) out += fmt::format(",\n{}\"required\": [{}]", indent_, required_);
    return out + fmt::format(",\n{}\"properties\": {{{}\n{}}}", indent_, properties_, indent_);
  }

 private:
  std::string object_body(const Describe& describe, int deeper) const {
    Schema inner(depth_ + deeper);
    describe(inner);
    return inner.body();
  }
  void add(const ConfigKey& key, const std::string& body) {
    properties_ +=
        fmt::format("{}\n{}  {}: {{\"description\": {}, {}}}", properties_.empty() ? "" : ",",
                    indent_, quoted(key.key), quoted(key.help), body);
    if (key.required) required_ += (required_.empty() ? "" : ", ") + quoted(key.key);
  }
  std::string indent_;
  int depth_;
  bool has_notes_ = false;
  std::string properties_;
  std::string required_;
};

}  // namespace

void read_config(const ConfigNode& node, const ConfigTable::Describe& describe) {
  if (!node.is_map()) node.fail("expected a map of keys to values");
  Reader reader(node);
  describe(reader);
  reader.finish();
}

std::string write_config(const ConfigTable::Describe& describe) {
  YAML::Emitter out;
  {
    Writer writer(out);
    describe(writer);
  }
  return std::string(out.c_str()) + "\n";
}

std::string config_schema(const std::string& title, const ConfigTable::Describe& describe) {
  Schema schema(0);
  describe(schema);
  return fmt::format(
      "{{\"$schema\": \"https://json-schema.org/draft/2020-12/schema\",\n\"title\": {},\n{}}}\n",
      quoted(title), schema.body());
}

}  // namespace seam
