// Whatever text stands in other people's tables, logs, storages and models, reading it ends well or
// in an InputError.
#include <nlohmann/json.hpp>

#include "app/import/draft/target.h"
#include "app/import/files/python_literal.h"
#include "app/import/files/signals.h"
#include "app/import/files/storage.h"
#include "app/import/files/text_table.h"
#include "app/import/pictures/finder.h"
#include "sim_core/base/error.h"

using namespace seam::app;

namespace {

template <typename Read>
void end_well(Read read) {
  try {
    read();
  } catch (const seam::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  end_well([&] {
    const TextTable table = TextTable::from_text(text, "input");
    for (size_t row = 0; row < table.rows(); ++row) {
      for (size_t column = 0; column < table.width(); ++column) {
        end_well([&] { table.number_or_blank(row, column); });
        end_well([&] { table.time_ns(row, column, 1'000'000'000); });
      }
    }
  });
  end_well([&] { signals_of_text(text, "input"); });
  end_well([&] { python_literal(text, "input"); });
  end_well([&] { answer_of(text, 54); });
  end_well([&] {
    const auto root = storage_of_text(text, "input");
    if (!root.is_map()) return;
    end_well([&] { read_target(root, {}); });
    for (const std::string& key : root.keys()) {
      end_well([&] { numbers_in(root.at(key), true); });
      if (is_matrix(root.at(key))) end_well([&] { matrix_rows(root.at(key)); });
    }
  });
  return 0;
}
