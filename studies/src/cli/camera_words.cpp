// Camera options, for all commands that render volumes.

#include "cli/command_line.hpp"
#include "cli/commands.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace maille::studies {

void add_camera(CLI::App* command, CameraOptions& camera) {
  command->add_option("--direction", camera.direction, "in which the eye looks, x,y,z")
      ->capture_default_str();
  command->add_option("--up", camera.up, "what is up, x,y,z")->capture_default_str();
  command->add_option("--camera", camera.camera,
                      "ParaView's: x,y,z of position, focal point and view up [m], and the view angle [deg]; "
                      "in place of --direction");
  command->add_flag("--parallel", camera.parallel, "orthographic");
  command->add_option("--zoom", camera.zoom, "nearer by a factor")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--clip", camera.clips,
                   "x,y,z,nx,ny,nz: keep the side that the normal points to; any number")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("--crop", camera.crop, "x0,y0,z0,x1,y1,z1: a box in the objects' own frames [m]");
  command->add_option("--width", camera.width, "[pixels]")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  command->add_option("--height", camera.height, "[pixels]")
      ->check(CLI::Range(1, 16384))
      ->capture_default_str();
  command->add_option("--samples", camera.samples, "a voxel, along rays")
      ->check(CLI::Range(0.1, 64.0))
      ->capture_default_str();
  command->add_option("--depth-cue", camera.depth_cue, "how dark what is far becomes")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--light", camera.light, "from where, in the camera's axes: right, up, to the eye")
      ->capture_default_str();
  command->add_option("--background", camera.background, "a colour")->capture_default_str();
}

void add_stereo(CLI::App* command, std::string& stereo) {
  command->add_option("--stereo", stereo, "for two eyes")
      ->check(CLI::IsMember({"none", "side_by_side", "anaglyph"}))
      ->capture_default_str();
}

} // namespace maille::studies
