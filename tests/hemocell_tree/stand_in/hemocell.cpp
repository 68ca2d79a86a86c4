// Like HemoCell, needs nothing newer than C++11.
static_assert(__cplusplus == 201103L, "the standard of the project around packMesh is its own");
int hemocell() {
  return 0;
}
