#include "sim_core/input/shown_text.h"

#include <fmt/format.h>

#include <cstdint>

namespace seam {
namespace {

// The character at the start of `text`; length 0 where no UTF-8 stands there.
struct Character {
  uint32_t code = 0;
  size_t length = 0;
};

Character first_of(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  uint32_t code = lead & (0xFF >> (length + 1));
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3F);
  }
  constexpr uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kSmallest[length] || code > 0x10FFFF || is_surrogate) return {};
  return {code, length};
}

bool acts_on_terminals(uint32_t code) {
  const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  const bool turns_direction = code == 0x200E || code == 0x200F || code == 0x061C ||
                               (code >= 0x202A && code <= 0x202E) ||
                               (code >= 0x2066 && code <= 0x2069);
  const bool ends_line = code == 0x2028 || code == 0x2029;
  return is_control || turns_direction || ends_line;
}

std::string shown_but(std::string_view text, std::string_view kept) {
  std::string out;
  while (!text.empty()) {
    const Character character = first_of(text);
    const size_t length = character.length > 0 ? character.length : 1;
    const bool is_kept = kept.find(text[0]) != std::string_view::npos;
    if (is_kept || (character.length > 0 && !acts_on_terminals(character.code))) {
      out += text.substr(0, length);
    } else if (character.code > 0xFF) {
      out += fmt::format("\\u{:04x}", character.code);
    } else {
      for (size_t i = 0; i < length; ++i)
        out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    }
    text.remove_prefix(length);
  }
  return out;
}

}  // namespace

std::string shown(std::string_view text) {
  return shown_but(text, "");
}

std::string shown_lines(std::string_view text) {
  return shown_but(text, "\n\t");
}

}  // namespace seam
