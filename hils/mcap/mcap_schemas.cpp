// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/mcap_schemas.hpp"

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;
using SchemaProperty = std::pair<std::string_view, OrderedJson>;

OrderedJson schema_of_type(std::string_view type, std::string_view description) {
  OrderedJson schema{{"type", type}};
  if (!description.empty()) schema["description"] = description;
  return schema;
}
OrderedJson schema_number(std::string_view description = {}) {
  return schema_of_type("number", description);
}
OrderedJson schema_integer(std::string_view description = {}) {
  return schema_of_type("integer", description);
}
OrderedJson schema_text(std::string_view description = {}) {
  return schema_of_type("string", description);
}
OrderedJson schema_boolean(std::string_view description = {}) {
  return schema_of_type("boolean", description);
}

OrderedJson schema_list(OrderedJson items, std::string_view description = {}) {
  OrderedJson schema = schema_of_type("array", description);
  schema["items"] = std::move(items);
  return schema;
}

OrderedJson schema_object(std::string_view title, std::string_view description,
                          std::initializer_list<SchemaProperty> properties) {
  OrderedJson schema{{"title", title}, {"type", "object"}};
  if (!description.empty()) schema["description"] = description;
  OrderedJson& all = schema["properties"] = OrderedJson::object();
  for (const auto& [name, property] : properties) all[std::string(name)] = property;
  return schema;
}

OrderedJson schema_moment(std::string_view title, std::string_view description) {
  return schema_object(title, description,
                       {{"sec", schema_integer("whole seconds")},
                        {"nsec", schema_integer("nanoseconds beyond them")}});
}
OrderedJson schema_timestamp() { return schema_moment("time", "simulated time"); }

OrderedJson schema_vector3(std::string_view description = {}) {
  return schema_object("foxglove.Vector3", description,
                       {{"x", schema_number()}, {"y", schema_number()}, {"z", schema_number()}});
}
OrderedJson schema_quaternion(std::string_view description = {}) {
  return schema_object("foxglove.Quaternion", description,
                       {{"x", schema_number()},
                        {"y", schema_number()},
                        {"z", schema_number()},
                        {"w", schema_number()}});
}
OrderedJson schema_point(std::string_view description = {}) {
  return schema_object("foxglove.Point3", description,
                       {{"x", schema_number()}, {"y", schema_number()}, {"z", schema_number()}});
}
OrderedJson schema_pose() {
  return schema_object("foxglove.Pose", "in the frame of the entity",
                       {{"position", schema_vector3("m")}, {"orientation", schema_quaternion()}});
}
OrderedJson schema_color() {
  return schema_object("foxglove.Color", "each 0 to 1; `a` is 0 where nothing is to be seen",
                       {{"r", schema_number()},
                        {"g", schema_number()},
                        {"b", schema_number()},
                        {"a", schema_number()}});
}
OrderedJson schema_pair() {
  return schema_object("foxglove.KeyValuePair", "",
                       {{"key", schema_text()}, {"value", schema_text()}});
}

OrderedJson schema_entity() {
  const OrderedJson arrow = schema_object("foxglove.ArrowPrimitive", "along x of its pose",
                                          {{"pose", schema_pose()},
                                           {"shaft_length", schema_number("m")},
                                           {"shaft_diameter", schema_number("m")},
                                           {"head_length", schema_number("m")},
                                           {"head_diameter", schema_number("m")},
                                           {"color", schema_color()}});
  const OrderedJson cube = schema_object(
      "foxglove.CubePrimitive", "a box about the origin of its pose",
      {{"pose", schema_pose()}, {"size", schema_vector3("edges, m")}, {"color", schema_color()}});
  const OrderedJson sphere =
      schema_object("foxglove.SpherePrimitive", "an ellipsoid about the origin of its pose",
                    {{"pose", schema_pose()},
                     {"size", schema_vector3("diameters, m")},
                     {"color", schema_color()}});
  const OrderedJson cylinder =
      schema_object("foxglove.CylinderPrimitive", "along z of its pose, about its origin",
                    {{"pose", schema_pose()},
                     {"size", schema_vector3("diameters and length, m")},
                     {"bottom_scale", schema_number("of the diameters at the lower end, 0 to 1")},
                     {"top_scale", schema_number("of the diameters at the upper end, 0 to 1")},
                     {"color", schema_color()}});
  const OrderedJson line = schema_object(
      "foxglove.LinePrimitive", "",
      {{"type", schema_integer("0: from point to point, 1: closed, 2: a line for each two points")},
       {"pose", schema_pose()},
       {"thickness", schema_number("m, or pixels")},
       {"scale_invariant", schema_boolean("the thickness is in pixels")},
       {"points", schema_list(schema_point(), "m")},
       {"color", schema_color()},
       {"colors", schema_list(schema_color(), "of each point; empty: `color`")},
       {"indices", schema_list(schema_integer(), "into the points; empty: in their order")}});
  const OrderedJson triangles = schema_object(
      "foxglove.TriangleListPrimitive", "",
      {{"pose", schema_pose()},
       {"points", schema_list(schema_point(), "m")},
       {"color", schema_color()},
       {"colors", schema_list(schema_color(), "of each point; empty: `color`")},
       {"indices", schema_list(schema_integer(), "three into the points for each triangle")}});
  const OrderedJson label =
      schema_object("foxglove.TextPrimitive", "",
                    {{"pose", schema_pose()},
                     {"billboard", schema_boolean("turns to the viewer")},
                     {"font_size", schema_number("m, or pixels")},
                     {"scale_invariant", schema_boolean("the size is in pixels")},
                     {"color", schema_color()},
                     {"text", schema_text()}});
  const OrderedJson model = schema_object("foxglove.ModelPrimitive", "a model from a file",
                                          {{"pose", schema_pose()},
                                           {"scale", schema_vector3()},
                                           {"color", schema_color()},
                                           {"override_color", schema_boolean()},
                                           {"url", schema_text()},
                                           {"media_type", schema_text()},
                                           {"data", schema_text("base 64")}});
  return schema_object(
      "foxglove.SceneEntity", "what is drawn together",
      {{"timestamp", schema_timestamp()},
       {"frame_id", schema_text("frame of its poses")},
       {"id", schema_text("a later entity of this id takes its place")},
       {"lifetime", schema_moment("duration", "0: until it is replaced or deleted")},
       {"frame_locked", schema_boolean("moves with its frame")},
       {"metadata", schema_list(schema_pair())},
       {"arrows", schema_list(arrow)},
       {"cubes", schema_list(cube)},
       {"spheres", schema_list(sphere)},
       {"cylinders", schema_list(cylinder)},
       {"lines", schema_list(line)},
       {"triangles", schema_list(triangles)},
       {"texts", schema_list(label)},
       {"models", schema_list(model)}});
}

McapSchema schema_named(const OrderedJson& schema) {
  return {.name = schema.at("title").get<std::string>(), .text = schema.dump()};
}

constexpr std::string_view kSchemaRpy =
    "rad, of forward-right-down axes in north-east-down ones, order yaw, pitch, roll";

}  // namespace

McapSchema frame_transform_schema() {
  return schema_named(schema_object(
      "foxglove.FrameTransform", "where the child is in its parent",
      {{"timestamp", schema_timestamp()},
       {"parent_frame_id", schema_text()},
       {"child_frame_id", schema_text()},
       {"translation", schema_vector3("m, on the axes of the parent")},
       {"rotation", schema_quaternion("turns vectors of the child into the parent")}}));
}

McapSchema scene_update_schema() {
  const OrderedJson deletion = schema_object("foxglove.SceneEntityDeletion", "",
                                             {{"timestamp", schema_timestamp()},
                                              {"type", schema_integer("0: of this id, 1: all")},
                                              {"id", schema_text()}});
  return schema_named(schema_object(
      "foxglove.SceneUpdate", "shapes",
      {{"deletions", schema_list(deletion)}, {"entities", schema_list(schema_entity())}}));
}

McapSchema location_fix_schema() {
  return schema_named(schema_object(
      "foxglove.LocationFix", "the true place on WGS 84",
      {{"timestamp", schema_timestamp()},
       {"frame_id", schema_text("of the vehicle")},
       {"latitude", schema_number("degrees")},
       {"longitude", schema_number("degrees")},
       {"altitude", schema_number("m; of CAS above mean sea level")},
       {"position_covariance", schema_list(schema_number(), "m^2, east, north, up, row by row")},
       {"position_covariance_type",
        schema_integer("0: unknown, 1: approximated, 2: its diagonal is known, 3: known")}}));
}

McapSchema vehicle_schema() {
  const OrderedJson rotor =
      schema_object("cas.Rotor", "",
                    {{"p_B", schema_list(schema_number(), "from the centre of gravity, m")},
                     {"axis_B", schema_list(schema_number(), "of its thrust")},
                     {"radius_m", schema_number()},
                     {"spin", schema_number("1: counterclockwise from above, -1")},
                     {"k_f", schema_number("N s^2: thrust over the square of its speed")},
                     {"omega_max_rad_s", schema_number()}});
  return schema_named(schema_object("cas.Vehicle", "",
                                    {{"vehicle", schema_text("its name")},
                                     {"model", schema_text("the name in its file")},
                                     {"system", schema_integer("MAVLink system")},
                                     {"mass_kg", schema_number()},
                                     {"rotors", schema_list(rotor)}}));
}

McapSchema truth_schema() {
  const OrderedJson wing =
      schema_object("cas.Wing", "of a vehicle with a wing",
                    {{"alpha_rad", schema_number("angle of attack")},
                     {"beta_rad", schema_number("sideslip")},
                     {"load_factor", schema_number()},
                     {"deflections_rad", schema_list(schema_number(), "of each surface")}});
  return schema_named(
      schema_object("cas.Truth", "true motion: W is east, north, up; B is forward, left, up",
                    {{"timestamp", schema_timestamp()},
                     {"vehicle", schema_text()},
                     {"position", schema_vector3("of the centre of gravity in W, m")},
                     {"velocity", schema_vector3("in W, m/s")},
                     {"orientation", schema_quaternion("turns vectors of B into W")},
                     {"angular_velocity", schema_vector3("in B, rad/s")},
                     {"roll", schema_number(kSchemaRpy)},
                     {"pitch", schema_number(kSchemaRpy)},
                     {"yaw", schema_number(kSchemaRpy)},
                     {"airspeed_m_s", schema_number("true; of a vehicle with a pitot tube")},
                     {"wing", wing}}));
}

McapSchema estimate_schema() {
  return schema_named(schema_object(
      "cas.Estimate", "the controller's estimate: LOCAL_POSITION_NED with the newest ATTITUDE",
      {{"timestamp", schema_timestamp()},
       {"vehicle", schema_text()},
       {"position", schema_vector3("east, north, up from the controller's origin, m")},
       {"velocity", schema_vector3("east, north, up, m/s")},
       {"orientation", schema_quaternion("turns vectors of B into W")},
       {"angular_velocity", schema_vector3("in B, rad/s")},
       {"roll", schema_number(kSchemaRpy)},
       {"pitch", schema_number(kSchemaRpy)},
       {"yaw", schema_number(kSchemaRpy)}}));
}

McapSchema reference_schema() {
  return schema_named(schema_object("cas.Reference", "where the vehicle was to be",
                                    {{"timestamp", schema_timestamp()},
                                     {"vehicle", schema_text()},
                                     {"position", schema_vector3("in W, m")},
                                     {"yaw", schema_number("rad, from north to the right")}}));
}

McapSchema motors_schema() {
  return schema_named(
      schema_object("cas.Motors", "true speeds",
                    {{"timestamp", schema_timestamp()},
                     {"vehicle", schema_text()},
                     {"speeds_rad_s", schema_list(schema_number(), "of each rotor")}}));
}

McapSchema motor_command_schema() {
  return schema_named(schema_object(
      "cas.MotorCommand", "the controller's command",
      {{"timestamp", schema_timestamp()},
       {"vehicle", schema_text()},
       {"armed", schema_boolean()},
       {"kind", schema_text("control_inputs: U1 to U4 in N and N m; outputs: rotors 0 to 1, "
                            "servos -1 to 1")},
       {"values", schema_list(schema_number())}}));
}

McapSchema mavlink_schema(std::uint32_t message_id) {
  OrderedJson properties = OrderedJson::object();
  for (const mav::FieldInfo& field : mavlink::common::fields_of(message_id)) {
    const std::string_view units = field.units;
    const std::string_view words = field.enum_name;
    const bool is_text = field.type == mav::FieldType::kChar;
    const bool is_real =
        field.type == mav::FieldType::kFloat || field.type == mav::FieldType::kDouble;
    OrderedJson value = is_text          ? schema_text()
                        : !words.empty() ? schema_text(words)
                        : is_real        ? schema_number(units)
                                         : schema_integer(units);
    const bool is_list = field.array_length > 0 && !is_text;
    properties[std::string(std::string_view(field.name))] =
        is_list ? schema_list(std::move(value)) : std::move(value);
  }
  properties["system"] = schema_integer("of the sender");
  properties["component"] = schema_integer("of the sender");
  const mav::MessageInfo* info = mavlink::common::table().find(message_id);
  const std::string title = "mavlink." + (info == nullptr ? "" : std::string(info->name));
  return schema_named({{"title", title},
                       {"type", "object"},
                       {"description", "by name where it has one; null is not a number"},
                       {"properties", std::move(properties)}});
}

}  // namespace cas::hils
