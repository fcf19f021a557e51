// What betamesh_pictures offers, inside it.

#include "render/picture_module.h"

#include "render/exr_file.h"
#include "render/png_file.h"
#include "render/render_frame.h"
#include "render/text.h"

extern "C" {
extern const betamesh::PictureModule betamesh_pictures;  // or it would be known in this file alone
const betamesh::PictureModule betamesh_pictures{betamesh::renderFrame, betamesh::encodeExr, betamesh::decodeExr,
                                                betamesh::encodePng,   betamesh::decodePng, betamesh::writeText};
}
