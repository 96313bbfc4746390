// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

namespace cas::sim {

/// Lift, drag and moment coefficients.
struct PanelCoefficients {
  double lift = 0;
  double drag = 0;
  double moment = 0;  ///< nose up, about the panel's place
};

/// Coefficients of a section by angle of attack, measured or computed, at one Reynolds number or
/// several: straight lines between the rows, those of the outer numbers beyond them. Beyond the
/// table's angles they become a flat plate's within 10 deg.
class PanelPolar {
 public:
  PanelPolar() = default;
  /// Reads a CSV file with the columns reynolds,alpha_deg,CL,CD,Cm: all angles of the least number
  /// first, both ascending.
  /// @param plate_normal_force  of the plate across the air
  /// @throws base::ConfigError naming file and line
  PanelPolar(const std::filesystem::path& file, double plate_normal_force);

  bool empty() const { return blocks_.empty(); }
  /// @param alpha_rad  from the chord, -pi..pi
  PanelCoefficients at(double alpha_rad, double reynolds) const;

 private:
  struct Row {
    double alpha_rad = 0;
    PanelCoefficients coefficients;
  };
  struct Block {
    double reynolds = 0;
    double least_drag = 0;
    std::vector<Row> rows;
  };
  PanelCoefficients of_block(const Block& block, double alpha_rad) const;

  std::vector<Block> blocks_;
  double plate_normal_force_ = 0;
};

}  // namespace cas::sim
