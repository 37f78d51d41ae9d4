#include "effects/model_schema.h"

#include "sim_core/input/schema_testing.h"

namespace seam::effects {
namespace {

TEST(ModelSchema, SchemaFileIsCurrent) {
  expect_page_is(std::string(SEAM_SOURCE_DIR) + "/docs/schemas/model.schema.json", model_schema());
}

}  // namespace
}  // namespace seam::effects
