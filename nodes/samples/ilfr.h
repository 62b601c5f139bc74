// ILFR 2.2, the sample files of the code published with Lehtinen et al. 2012: records of 39 floats
//   x y w  u v t  r g b  then ten 3D vectors: pri_mv pri_normal albedo sec_origin sec_hitpoint
//   sec_mv sec_normal direct sec_albedo sec_direct
// and a matrix M that takes (x, y, 0, 1) to the plane in focus, seen from the lens centre.
//
//   sec_origin (the primary hit, camera space)  position, and z along the camera's axis
//   sec_mv (camera space; of the primary hit in lens and motion buffers)  secondary_motion, and
//   motion pri_normal, sec_hitpoint, sec_normal, albedo, sec_albedo, direct, sec_direct
//                      normal, position2, normal2, albedo, albedo2, direct, secondary_direct
//   w (bandwidth of the reflectance at the second hit)  bandwidth;  pri_mv  primary_motion
//
// meta.camera.camera_to_pixel is the 3x3 matrix that takes a point of camera space to (x z, y z,
// z); pixel_to_camera is M as it stood. Writing a buffer that was read from ILFR with channels "*"
// gives the same records. One that was not is written in a camera space of pixels, (x z, y z, z),
// in which depth and motion are exact.
#pragma once
#include "samples/record_file.h"
#include "samples/sample_file.h"

namespace weft {

Samples read_ilfr(const RecordFiles& files, const RecordHeader& header, const ReadOptions& options,
                  Context& ctx);
void write_ilfr(const Samples& samples, const std::string& path, bool text, Context& ctx);

}  // namespace weft
