#pragma once
/// The plan with predictions that were measured on the scene: what `taut render`, `info` and the view plan by.
///
/// The analysis of plan.h knows how errors grow from choice to choice, but only bounds how large they are in the picture. A pilot
/// (pilot_picture.h) measures one choice of each kind; the others follow by the analysis. Pilots are made where a tolerance or an error is
/// asked for, or a mesh's level is the plan's, and only as many as fit into kPilotShare of the time that the whole job would take in full.
/// That time is counted, from faces, pixels, samples and frames (costs.h), so the plan depends on the scene alone.

#include "taut/plan/plan.h"

namespace taut {

/// Share of the foreseen time that pilots may take.
inline constexpr double kPilotShare = 0.03;

/// As planScene(). Renders parts of one frame (ScenePlanner::hardestFrame). Where `options.error` is asked for, the plan's budget says how
/// it is split.
PlannedScene planByPilots(const Scene &scene, const PlanOptions &options = {});

} // namespace taut
