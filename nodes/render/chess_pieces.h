// Chess pieces, turned on a lathe. One unit is a square of the board; they stand on y = 0 and look
// along -z.
#pragma once
#include <array>

#include "render/scene.h"

namespace weft {

enum class ChessPiece { pawn, rook, knight, bishop, queen, king };

Mesh chess_piece_mesh(ChessPiece piece, int segments);

}  // namespace weft
