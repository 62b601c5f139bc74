// build-hierarchy: sorts samples for search over lens and shutter (hierarchy.h,
// build_hierarchy_kernel.h). grid-hierarchy: the same in uniform cells that know nothing of depth,
// to compare with.
#include "light-field/build_hierarchy_kernel.h"
#include "runtime/node.h"

namespace weft {
namespace {

template <light_field::Arrangement arrangement>
struct HierarchyNode {
    float radius_scale = 1;

    static void declare_with(Ports<HierarchyNode>& node, const char* about) {
        node.about(about)
            .template in<Samples>("samples",
                                  "xy, z and rgb; uv with a lens, t and motion where it has them")
            .template out<Hierarchy>(
                "hierarchy", "the samples as seen from the lens centre at half time, sorted")
            .param("radius-scale", &HierarchyNode::radius_scale,
                   {.min = 0.05,
                    .max = 20,
                    .about = "of the radius R of the gaps expected between samples, 2.2 / sqrt(spp "
                             "+ 0.2) px; pixel by pixel where spp varies"});
    }
    static void declare(Ports<HierarchyNode>& node) {
        declare_with(node, arrangement == light_field::Arrangement::layers
                               ? "sorts samples by place, depth and motion, with bounds over lens "
                                 "and shutter for groups of 16"
                               : "sorts samples into uniform cells of the picture, whatever their "
                                 "depth and motion");
    }
    Cost cost(const Shapes& in) const {
        // What sorting takes is gone before the result's memory is asked for.
        const double n = double(in["samples"].records);
        return {{{"hierarchy",
                  {in["samples"].width, in["samples"].height, 0, in["samples"].records, 64 * n}}},
                0,
                100 * n};
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const {
        out.set("hierarchy", light_field::build_hierarchy(in.get<Samples>("samples"), arrangement,
                                                          radius_scale, ctx));
    }
};

using BuildHierarchy = HierarchyNode<light_field::Arrangement::layers>;
using GridHierarchy = HierarchyNode<light_field::Arrangement::cells>;

WEFT_NODE(BuildHierarchy, "build-hierarchy", 2)
WEFT_NODE(GridHierarchy, "grid-hierarchy", 2)

}  // namespace
}  // namespace weft
