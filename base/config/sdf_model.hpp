// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "base/config/model_body.hpp"
#include "base/config/xml_tree.hpp"

namespace cas::base {

/// Reads the first <model> of an SDF file as a vehicle, with the models that it includes and nests.
///
/// Poses are resolved as SDF 1.4 to 1.11 say: in Euler angles, `relative_to` a link, joint, frame
/// or nested model. A continuous joint turns, and so does a revolute one whose limits allow a full
/// turn; others count as fixed. Links of an included or nested model are called "PART::LINK", and
/// with merge='true' as in their own file. An included file is looked for as in a world
/// (places_of_model_file()), and beside the folder of the file that includes it.
/// @throws ConfigError "FILE:LINE: ..." where the file holds no such model, or a part is missing
///     that `parts` does not leave out
ModelBody read_sdf_model(const XmlElement& sdf, const std::filesystem::path& file,
                         const ModelParts& parts);

}  // namespace cas::base
