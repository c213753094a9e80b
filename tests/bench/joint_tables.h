/// Tables of the joints benchmark.
#pragma once

#include "tests/bench/bench_scenes.h"

namespace kirireel::bench {

/// Largest joint gap over whole deployments of all models, contacts on.
void printGapTable(const std::vector<NamedScene>& models);

/// Sheets of n x n tiles, n = 4, 10, 20, 40, from 0 to 90 degrees against the exact motion.
void printTessellationTable();

/// CPU time per step against Bullet at the same step, planar and in space, and growth exponents.
void printSpeedTable();

/// The largest step that keeps the exact motion at 100 tiles, and its cost against Bullet.
void printLargestStepTable();

/// The effect of the step on the path in time: a sheet, square2disk and cylinder.
void printPathTable(const std::vector<NamedScene>& models);

/// Planar sheets of 10,000 tiles.
void printLargeSheetTable();

/// With brick contact on: cost and penetration against Bullet.
void printContactTable(const std::vector<NamedScene>& models);

/// Every stiffness, damping, step and thickness on a sheet and published models.
void printStabilityTable(const std::vector<NamedScene>& models, bool contacts);

/// Costs of assembling, factoring and solving the system of one step.
void printShareTable();

}  // namespace kirireel::bench
