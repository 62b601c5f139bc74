# weft_nodes(family SOURCES... [LIBRARIES...]): nodes and kernels of one family, an object library
# that programs link whole (a node registers itself when its object file is loaded).
set_property(GLOBAL PROPERTY WEFT_FAMILIES "")
function(weft_nodes family)
    cmake_parse_arguments(arg "" "" "SOURCES;LIBRARIES" ${ARGN})
    add_library(weft_nodes_${family} OBJECT ${arg_SOURCES})
    target_link_libraries(weft_nodes_${family} PUBLIC weft_runtime weft_types fmt::fmt ${arg_LIBRARIES})
    set_property(GLOBAL APPEND PROPERTY WEFT_FAMILIES weft_nodes_${family})
endfunction()

# weft_kernels(family SOURCES...): each source is compiled once an instruction set, with WEFT_ISA
# defined as v2, v3 or v4 (x86-64 levels: SSE4, AVX2, AVX-512); kernels put themselves into
# namespace WEFT_ISA and runtime/isa.h picks one at run time.
function(weft_kernels family)
    foreach(isa v2 v3 v4)
        add_library(weft_kernels_${family}_${isa} OBJECT ${ARGN})
        target_compile_options(weft_kernels_${family}_${isa} PRIVATE -march=x86-64-${isa} -maes -mpclmul -O3)
        if(isa STREQUAL v4)
            target_compile_options(weft_kernels_${family}_${isa} PRIVATE -mprefer-vector-width=512)
        endif()
        target_compile_definitions(weft_kernels_${family}_${isa} PRIVATE WEFT_ISA=${isa} HWY_COMPILE_ONLY_STATIC)
        set_property(GLOBAL APPEND PROPERTY WEFT_FAMILIES weft_kernels_${family}_${isa})
    endforeach()
endfunction()

# weft_link_nodes(target): links every family whole into a program.
function(weft_link_nodes target)
    get_property(families GLOBAL PROPERTY WEFT_FAMILIES)
    foreach(family ${families})
        target_link_libraries(${target} PRIVATE ${family})
    endforeach()
    target_link_libraries(${target} PRIVATE weft_runtime weft_types)
endfunction()
