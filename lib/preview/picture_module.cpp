// What betamesh_pictures offers, inside it.

#include "preview/picture_module.h"

#include "preview/exr_file.h"
#include "preview/png_file.h"
#include "preview/render_frame.h"
#include "preview/text.h"

extern "C" {
extern const betamesh::PictureModule betamesh_pictures;  // or it would be known in this file alone
const betamesh::PictureModule betamesh_pictures{betamesh::renderFrame, betamesh::encodeExr, betamesh::decodeExr,
                                                betamesh::encodePng,   betamesh::decodePng, betamesh::writeText};
}
