// Pictures of frames: what is in front of the camera, where the camera stands, the files.

#pragma once

#include "batch/config/config.h"
#include "batch/platform/worker.h"
#include "render/render_frame.h"

#include <map>
#include <string>

namespace betamesh {

/// What is in front of the camera in one frame.
struct Subject {
    Mesh mesh;
    Spheres spheres;
};

/// Reads a mesh with the spheres beside it, or particles, as balls of this radius where they bring none (`radius`,
/// `pscale`) themselves.
///
/// errors  as readMesh and readParticles
Subject readSubject(const std::string& file, const Config& config, double radius);

/// Balls round particles, which move with them.
Spheres ballsOf(const Particles& particles, double radius);

/// What all frames of a sequence take up together.
struct Extent {
    CameraFinder finder;
    Bounds bounds;
    double squares = 0;      ///< sum of all speeds squared, world units per second
    std::size_t speeds = 0;  ///< so many
    std::optional<CutawayPlane> cut;  ///< what it leaves away does not count

    explicit Extent(const Config::Preview& preview);
    void add(const Subject& subject);
    void add(const Extent& other);
    /// The root of the mean square; 0 where nothing has a velocity.
    double speed() const;
};

/// Reads the files, several at once or one after the other, and keeps none. One that cannot be read does not count.
///
/// same    for any thread count
Extent extentOf(const std::map<int, std::string>& files, const Config& config, double radius, const WorkerEvents& notes,
                bool several_at_once);

/// How all pictures of a sequence are taken.
struct PreviewPlan {
    Camera camera;
    RenderSettings settings;
    double ball = 0;  ///< the radius of particles that are shown as balls, world units
};

/// Whether pictures cannot be planned without knowing what the sequence takes up.
bool needsExtent(const Config& config);

PreviewPlan planPreview(const Config& config, const Extent& extent, double ball);

/// The camera and the ground, as options that give them back.
std::string describe(const PreviewPlan& plan);

/// Whether a name ends in .exr; errors: in neither .exr nor .png.
bool isExr(const std::string& path);

/// A file of the kind that its name asks for.
std::string encodePicture(const Picture& picture, const std::string& path);

}  // namespace betamesh
