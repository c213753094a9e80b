/// The equilibria of a run under grips in its trajectory.h5.
#pragma once

#include <filesystem>
#include <optional>

#include "sim/mechanics/load_path.h"

namespace kirireel::record {

/// Adds the equilibria to a finished trajectory.h5. States are the rows of load_curve.csv, grips
/// the directions of each [[grip]]. Throws OutputError if the file cannot be written.
///
///     load_curve/             attribute leading: the index of the grip of the stiffness
///       grip                  grips            texts such as "grip 1 x"
///       is_turn               grips            1: rad and N m, 0: m and N
///       load                  states           1 is the whole load
///       energy                states           J
///       stiffness             states           N/m or N m/rad
///       unstable_modes        states
///       turning               states           0 none, 1 limit of the load, 2 limit of the force,
///                                              3 bifurcation
///       displacement, force   states x grips   m and N, or rad and N m
void addLoadCurve(const std::filesystem::path& trajectory, const mechanics::LoadCurve& curve);

/// The equilibria in a trajectory.h5, without poses. Absent for runs without grips. Throws
/// InputError if the file is damaged.
std::optional<mechanics::LoadCurve> readLoadCurve(const std::filesystem::path& trajectory);

}  // namespace kirireel::record
