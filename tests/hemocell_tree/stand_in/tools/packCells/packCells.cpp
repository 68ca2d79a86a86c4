// HemoCell has packCells here; packMesh knows the tree by it.
