// Renders frames: reads what is shown, places the camera for a whole sequence, encodes the previews.

#pragma once

#include "batch/config/config.h"
#include "batch/job/input_frames.h"
#include "batch/platform/worker.h"
#include "render/render_frame.h"

#include <map>
#include <string>

namespace betamesh {

/// The geometry that is rendered for one frame.
struct FrameGeometry {
    Mesh mesh;
    Spheres spheres;
};

/// The balls by which particles are shown.
struct ParticleBalls {
    double radius = 0;        ///< world units; with an attribute, of a particle whose size is `spacing`
    double spacing = 0;       ///< world units
    std::string attribute{};  ///< as SkinParams::radius_attribute
    double scale = 1;         ///< as SkinParams::radius_scale
    std::string colour{};     ///< attribute of particles that balls have, too, to be coloured by; empty: none
};

/// Reads a mesh with its spheres, or particles, which are shown as balls, with the attribute that the preview is
/// coloured by.
///
/// errors  those of readMesh(), readParticles() and ballsAround(), with the name of the file
FrameGeometry readFrameGeometry(const FileFrame& of, const Config& config, ParticleBalls balls);

/// Whether a file is named like those of spheres beside meshes, as in splash.0012.spheres.ply. Its points are shown
/// with their own radii.
bool isSpheresFile(const std::string& file);

/// One ball per particle, with its velocity and the attribute that it is coloured by.
///
/// errors  those of particleSizes(); particles that lack this attribute
Spheres ballsAround(const Particles& particles, const ParticleBalls& balls);

/// The extent of all frames of a sequence together, from which the automatic camera, ground and colours follow.
struct Extent {
    CameraFinder finder;
    Bounds bounds;
    double squares = 0;               ///< sum of squared speeds, (world units per second)²
    std::size_t speeds = 0;           ///< number of finite velocities
    std::optional<CutawayPlane> cut;  ///< geometry that it cuts away is ignored

    explicit Extent(const Config::Preview& preview);
    void add(const FrameGeometry& subject);
    void add(const Extent& other);
    /// Root mean square speed, world units per second; 0 if nothing has a velocity.
    double speed() const;
};

/// Reads all files and returns their extent. Files that cannot be read are ignored here: meshing them reports the
/// error.
///
/// in      files by frame; the balls of particles; events are told which frames are measured;
///         several_at_once: in parallel, otherwise one at a time
/// same    results for any number of threads
Extent sequenceExtent(const std::map<int, std::string>& files, const Config& config, const ParticleBalls& balls,
                      const WorkerEvents& events, bool several_at_once);

/// Camera and settings for all previews of a sequence.
struct RenderPlan {
    Camera camera;
    RenderSettings settings;
    ParticleBalls balls;  ///< of particles that are shown as balls, with their colour
};

/// Whether camera, ground or colours depend on the extent of the sequence.
bool needsExtent(const Config& config);

/// in      extent: needed only if needsExtent(); balls: RenderPlan::balls
RenderPlan planRendering(const Config& config, const Extent& extent, const ParticleBalls& balls);

/// The options that reproduce this camera and ground.
std::string describe(const RenderPlan& plan);

/// Whether the extension is .exr.
///
/// errors  an extension other than .exr and .png
bool isExr(const std::string& path);

/// The bytes of a preview in the format of the path's extension.
std::string encodePicture(const Picture& picture, const std::string& path);

}  // namespace betamesh
