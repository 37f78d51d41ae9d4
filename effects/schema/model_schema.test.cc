#include "effects/schema/model_schema.h"

#include "effects/model.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/input/schema_testing.h"

namespace seam::effects {
namespace {

TEST(ModelSchema, SchemaFileIsCurrent) {
  expect_page_is(std::string(SEAM_SOURCE_DIR) + "/docs/reference/schemas/model.schema.json",
                 model_schema());
}

std::string refusal_of_model(const std::string& effects) {
  try {
    Model::from_config(
        ConfigNode::from_text("format: seam-model/1\neffects: " + effects + "\n", "m.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// A name that is misspelt is what the user has to mend, not the one that it leaves without a value.
TEST(ModelFile, NamesTheUnknownParameterBeforeTheMissingOne) {
  const std::string rest = ", fy_px: 300, cx_px: 160, cy_px: 120}}";
  const std::string text = refusal_of_model("{pinhole: {fx_pix: 300" + rest);
  EXPECT_NE(
      text.find("m.yaml:2: effects.pinhole: unknown parameter 'fx_pix', did you mean 'fx_px'?"),
      std::string::npos)
      << text;
  EXPECT_NE(refusal_of_model("{pinhole: {fx_px: {valeu: 300}" + rest)
                .find("unknown key 'valeu', did you mean"),
            std::string::npos);
  EXPECT_NE(refusal_of_model("{pinhole: {fy_px: 300, cx_px: 160, cy_px: 120}}")
                .find("parameter 'fx_px' is missing"),
            std::string::npos);
  EXPECT_EQ(refusal_of_model("{pinhole: {fx_px: 300" + rest), "");
  EXPECT_NE(
      refusal_of_model("{pinhol: {fx_px: 300" + rest).find("unknown effect 'pinhol', did you mean"),
      std::string::npos);
}

}  // namespace
}  // namespace seam::effects
