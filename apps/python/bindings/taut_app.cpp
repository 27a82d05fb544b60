#include "taut_app.h"

#include "../../taut/exporter.h"
#include "../../taut/info_report.h"
#include "../../taut/json_text.h"

namespace taut::app {

std::string planText(const RenderScene &ready, const std::vector<GradientField> &fields) {
    return jsonText(toJson(Report{ready.scene(), ready, fields}), -1);
}

std::string exportText(const Scene &scene, const std::vector<std::string> &outputs, const std::vector<std::string> &objects,
                       const std::string &convention, const std::string &positions, const std::string &space, bool ascii,
                       Warnings &warnings) {
    return jsonText(exportFiles(scene, {outputs, objects, convention, positions, space, ascii}, warnings), -1);
}

} // namespace taut::app
