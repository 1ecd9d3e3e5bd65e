// Materials, textures and samplers of a document to ours: out-of-range factors are clamped and noted,
// textures that cannot be used (WebP, KTX2, a third uv set) are dropped and noted, junk in place of an image
// is a UserError.
#pragma once

#include "scenes/gltf/document.hpp"
#include "scenes/scene.hpp"

namespace aluminate::scenes::gltf {

/// Same order and indices as /images. Bytes are moved out of the document.
std::vector<EncodedImage> take_images(Document& document);

/// Same order and indices as /materials. Slots refer to `images`.
std::vector<Material> read_materials(Document& document, const std::vector<EncodedImage>& images);

}  // namespace aluminate::scenes::gltf
