#include "color/shipped_config.h"

namespace weft {

std::string_view shipped_config_text() {
    return R"ocio(ocio_profile_version: 2
environment: {}
search_path: ""
strictparsing: true
name: weft-1
roles:
  default: ACEScg
  scene_linear: ACEScg
  aces_interchange: ACES2065-1
  cie_xyz_d65_interchange: CIE-XYZ-D65
  color_timing: ACEScct
  compositing_log: ACEScct
  data: Raw
  texture_paint: sRGB - Texture
file_rules:
  - !<Rule> {name: Default, colorspace: default}
shared_views:
  - !<View> {name: ACES 1.0 SDR, view_transform: ACES 1.0 SDR, display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: ACES 1.1 SDR (P3 lim), view_transform: ACES 1.1 SDR (P3 lim), display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: ACES 1.1 HDR (1000 nits), view_transform: ACES 1.1 HDR (1000 nits), display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: <USE_DISPLAY_NAME>}
  - !<View> {name: Raw, colorspace: Raw}
displays:
  sRGB:
    - !<Views> [ACES 1.0 SDR, Un-tone-mapped, Raw]
  Rec.709:
    - !<Views> [ACES 1.0 SDR, Un-tone-mapped, Raw]
  Display P3:
    - !<Views> [ACES 1.1 SDR (P3 lim), ACES 1.0 SDR, Un-tone-mapped, Raw]
  Rec.2100-PQ:
    - !<Views> [ACES 1.1 HDR (1000 nits), Un-tone-mapped, Raw]
active_displays: []
active_views: []
default_view_transform: Un-tone-mapped
view_transforms:
  - !<ViewTransform>
    name: Un-tone-mapped
    from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}
  - !<ViewTransform>
    name: ACES 1.0 SDR
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0}
  - !<ViewTransform>
    name: ACES 1.1 SDR (P3 lim)
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO-P3lim_1.1}
  - !<ViewTransform>
    name: ACES 1.1 HDR (1000 nits)
    from_scene_reference: !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - HDR-VIDEO-1000nit-15nit-REC2020lim_1.1}
display_colorspaces:
  - !<ColorSpace>
    name: CIE-XYZ-D65
    bitdepth: 32f
  - !<ColorSpace>
    name: sRGB
    aliases: [sRGB - Display]
    encoding: sdr-video
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}
  - !<ColorSpace>
    name: Rec.709
    aliases: [Rec.1886 Rec.709 - Display]
    encoding: sdr-video
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709}
  - !<ColorSpace>
    name: Display P3
    aliases: [Display P3 - Display]
    encoding: sdr-video
    from_display_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [2.493496911941, -0.931383617919, -0.402710784451, 0, -0.829488969562, 1.762664060318, 0.023624685842, 0, 0.035845830244, -0.076172389268, 0.956884524008, 0, 0, 0, 0, 1]}
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}
  - !<ColorSpace>
    name: Rec.2100-PQ
    aliases: [Rec.2100-PQ - Display]
    encoding: hdr-video
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.2100-PQ}
colorspaces:
  - !<ColorSpace>
    name: ACES2065-1
    aliases: [aces2065_1, lin_ap0]
    encoding: scene-linear
  - !<ColorSpace>
    name: ACEScg
    aliases: [lin_ap1]
    encoding: scene-linear
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: ACEScct
    encoding: log
    to_scene_reference: !<BuiltinTransform> {style: ACEScct_to_ACES2065-1}
  - !<ColorSpace>
    name: lin_rec709
    aliases: [Linear Rec.709 (sRGB), lin_srgb]
    encoding: scene-linear
    to_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD, direction: inverse}
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: lin_p3d65
    aliases: [Linear P3-D65]
    encoding: scene-linear
    to_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.486570948648, 0.265667693169, 0.198217285234, 0, 0.228974564070, 0.691738521837, 0.079286914094, 0, 0, 0.045113381859, 1.043944368901, 0, 0, 0, 0, 1]}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD, direction: inverse}
  - !<ColorSpace>
    name: lin_rec2020
    aliases: [Linear Rec.2020]
    encoding: scene-linear
    to_scene_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.636958048301, 0.144616903586, 0.168880975164, 0, 0.262700212011, 0.677998071519, 0.059301716470, 0, 0, 0.028072693049, 1.060985057711, 0, 0, 0, 0, 1]}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD, direction: inverse}
  - !<ColorSpace>
    name: sRGB - Texture
    aliases: [srgb_tx]
    encoding: sdr-video
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD, direction: inverse}
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: Raw
    isdata: true
)ocio";
}

}  // namespace weft
