// What is imported, a function a kind: each fills the draft from the files of the request. The
// table of kinds with their help is app/import/table.cc.
#pragma once

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

void import_images(const ImportRequest& request, SetDraft& draft);
void import_servo(const ImportRequest& request, SetDraft& draft);
void import_ranges(const ImportRequest& request, SetDraft& draft);
void import_opencv(const ImportRequest& request, SetDraft& draft);
void import_kalibr(const ImportRequest& request, SetDraft& draft);
void import_mrcal(const ImportRequest& request, SetDraft& draft);
void import_bouguet(const ImportRequest& request, SetDraft& draft);
void import_euroc(const ImportRequest& request, SetDraft& draft);
void import_tum(const ImportRequest& request, SetDraft& draft);
void import_emva1288(const ImportRequest& request, SetDraft& draft);
void import_flats(const ImportRequest& request, SetDraft& draft);
void import_log(const ImportRequest& request, SetDraft& draft);
void import_wheels(const ImportRequest& request, SetDraft& draft);
void import_imu(const ImportRequest& request, SetDraft& draft);
void import_ros(const ImportRequest& request, SetDraft& draft);

}  // namespace seam::app
