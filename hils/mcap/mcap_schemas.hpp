// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace cas::hils {

/// A JSON Schema with its name. Texts are in our own words; names and fields of foxglove.* are
/// those of Foxglove's message schemas (docs.foxglove.dev, "Message schemas").
struct McapSchema {
  std::string name;
  std::string text;
};

/// foxglove.FrameTransform: where a frame is in another.
McapSchema frame_transform_schema();
/// foxglove.SceneUpdate: shapes to draw, until another entity of the same id comes.
McapSchema scene_update_schema();
/// foxglove.LocationFix: a place on Earth.
McapSchema location_fix_schema();

/// cas.Vehicle: a vehicle and its rotors, once.
McapSchema vehicle_schema();
/// cas.Truth: the true motion, axes of W and B.
McapSchema truth_schema();
/// cas.Estimate: the controller's own estimate, from its own origin.
McapSchema estimate_schema();
/// cas.Reference: where the vehicle was to be.
McapSchema reference_schema();
/// cas.Motors: true speeds of the rotors.
McapSchema motors_schema();
/// cas.MotorCommand: what the controller commanded.
McapSchema motor_command_schema();

/// mavlink.NAME: a message of the project's dialect, as its tables have it.
/// @param message_id  of a known message
McapSchema mavlink_schema(std::uint32_t message_id);

}  // namespace cas::hils
