// $title: a case of HemoCell, written by packMesh $version.
//   $command
#include <hemocell.h>

#include <csignal>
#include <iostream>

#include <fluidInfo.h>
#include <helper/voxelizeDomain.h>
#include <pltSimpleModel.h>
#include <rbcHighOrderModel.h>
#include "palabos3D.h"
#include "palabos3D.hh"

#include <packMesh/hemocell.h>

using namespace hemo;
using namespace plb;

static volatile std::sig_atomic_t asked = 0;
static void askToStop(int) {
  asked = 1;
}

/// Whether a signal has reached any rank: of a batch queue before its time limit, or Ctrl-C.
static bool stopped() {
  int any = asked;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return any != 0;
}

static void setForce(HemoCell& hemocell, double x) {                                          //@periodic
  setExternalVector(*hemocell.lattice, hemocell.lattice->getBoundingBox(),                    //@periodic
                    DESCRIPTOR<T>::ExternalField::forceBeginsAt, plb::Array<T, 3>(x, 0, 0));  //@periodic
}  //@periodic
/// The fluid nodes of a plane of nodes get the pressure of the outflow. HemoCell deletes cells that reach
/// them.  //@inlet
static void openOutlet(HemoCell& hemocell, MultiScalarField3D<int>& fluid, Box3D plane, char axis,
                       int side) {  //@inlet
  BoundaryConditionInstantiator3D<T, DESCRIPTOR, WrappedZouHeBoundaryManager3D<T, DESCRIPTOR> >
      boundary;                                                           //@inlet
  for (plint x = plane.x0; x <= plane.x1; ++x)                            //@inlet
    for (plint y = plane.y0; y <= plane.y1; ++y)                          //@inlet
      for (plint z = plane.z0; z <= plane.z1; ++z) {                      //@inlet
        if (!fluid.get(x, y, z) || hemocell.partOfpreInlet) continue;     //@inlet
        const Box3D node(x, x, y, y, z, z);                               //@inlet
        MultiBlockLattice3D<T, DESCRIPTOR>& lattice = *hemocell.lattice;  //@inlet
        if (axis == 'x' && side > 0)
          boundary.addPressureBoundary0P(node, lattice, boundary::density);  //@inlet
        if (axis == 'y' && side < 0)
          boundary.addPressureBoundary1N(node, lattice, boundary::density);  //@inlet
        if (axis == 'y' && side > 0)
          boundary.addPressureBoundary1P(node, lattice, boundary::density);  //@inlet
        if (axis == 'z' && side < 0)
          boundary.addPressureBoundary2N(node, lattice, boundary::density);  //@inlet
        if (axis == 'z' && side > 0)
          boundary.addPressureBoundary2P(node, lattice, boundary::density);  //@inlet
        setBoundaryDensity(lattice, node, 1.0);                              //@inlet
      }                                                                      //@inlet
}  //@inlet

int main(int argc, char* argv[]) {
  if (argc != 2) {
    std::cerr << "Usage: " << argv[0] << " config.xml, or output/checkpoint/checkpoint.xml to continue"
              << std::endl;
    return 1;
  }
  HemoCell hemocell(argv[1], argc, argv);
  Config& config = *hemocell.cfg;

  // The lattice: nodes inside the surface are fluid, all others walls.
  MultiScalarField3D<int>* fluid = 0;
  VoxelizedDomain3D<T>* domain = 0;
  getFlagMatrixFromSTL(
      config["domain"]["geometry"].read<string>(), config["domain"]["fluidEnvelope"].read<int>(),
      config["domain"]["refDirN"].read<int>(), config["domain"]["refDir"].read<int>(), domain, fluid,
      config["domain"]["blockSize"].read<int>(), config["domain"]["particleEnvelope"].read<int>());
  param::lbm_base_parameters(config);
  hemocell.preInlet = new hemo::PreInlet(&hemocell, fluid);      //@inlet
  hemocell.preInlet->autoPreinletFromBoundary(Direction::Xneg);  //@inlet
  hemocell.initializeLattice(domain->getMultiBlockManagement());
  hemocell.lattice->periodicity().toggleAll(false);  //@periodic
  defineDynamics(*hemocell.lattice, *fluid, hemocell.lattice->getBoundingBox(),
                 new BounceBack<T, DESCRIPTOR>(1.), 0);                            //@periodic
  if (!hemocell.partOfpreInlet) hemocell.lattice->periodicity().toggleAll(false);  //@inlet
  hemocell.preInlet->initializePreInlet();                                         //@inlet
  boundaryFromFlagMatrix(hemocell.lattice, fluid, hemocell.partOfpreInlet);        //@inlet
  hemocell.preInlet->createBoundary();                                             //@inlet
  for (plint y = 0; y <= $last_y;
       ++y)  // HemoCell copies the last plane of the surface outwards, here to x = $last_x //@inlet
    for (plint z = 0; z <= $last_z; ++z)                                                      //@inlet
      if (fluid->get($last_x, y, z) && !hemocell.partOfpreInlet)                              //@inlet
        defineDynamics(*hemocell.lattice, $last_x, y, z, new BounceBack<T, DESCRIPTOR>(1.));  //@inlet
  $outlets hemocell.lattice->toggleInternalStatistics(false);
  hemocell.latticeEquilibrium(1., plb::Array<T, 3>(0., 0., 0.));
  hemocell.preInlet->calculateDrivingForce();  //@inlet
  hemocell.lattice->initialize();

  // The cells: their membranes are those of RBC.xml and PLT.xml, packed as <packing> says.
  hemocell.initializeCellfield();
  hemocell.addCellType<RbcHighOrderModel>("RBC", RBC_FROM_SPHERE);
  hemocell.addCellType<PltSimpleModel>("PLT", ELLIPSOID_FROM_SPHERE);
  for (const char* name : {"RBC", "PLT"}) {
    hemocell.setMaterialTimeScaleSeparation(name, config["ibm"]["stepMaterialEvery"].read<int>());
    hemocell.setOutputs(
        name, {OUTPUT_POSITION, OUTPUT_TRIANGLES, OUTPUT_FORCE, OUTPUT_CELL_ID});  // what packmesh run reads
  }
  hemocell.setParticleVelocityUpdateTimeScaleSeparation(config["ibm"]["stepParticleEvery"].read<int>());
  hemocell.setFluidOutputs({OUTPUT_VELOCITY, OUTPUT_DENSITY});
  hemocell.setSystemPeriodicity(0, true);  //@periodic
  if (config.checkpointed) {
    packmesh::loadCheckPoint(hemocell);
  } else {
    packmesh::loadParticles(hemocell);
    hemocell.writeOutput();
  }

  // The flow.
  const unsigned int tmax = config["sim"]["tmax"].read<unsigned int>();
  const unsigned int tmeas = config["sim"]["tmeas"].read<unsigned int>();
  const unsigned int tcheckpoint = config["sim"]["tcheckpoint"].read<unsigned int>();
  const double force = config["drive"]["bodyForce"].read<double>() / param::rho_p * param::dt * param::dt /
                       param::dx;  //@periodic
  hemocell.checkExitSignals();     // HemoCell's handlers, which end the program; ours save a checkpoint
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) std::signal(signal, askToStop);
  bool stop = false;
  while (hemocell.iter < tmax && !stop) {
    setForce(hemocell, force);  //@periodic
    hemocell.iterate();
    if (hemocell.partOfpreInlet) hemocell.preInlet->setDrivingForce();  //@inlet
    hemocell.preInlet->applyPreInlet();                                 //@inlet
    packmesh::watchCells(
        hemocell);  // warns of cells that HemoCell has deleted, or will delete since they are too long
    if (hemocell.iter % tmeas == 0) {
      packmesh::WatchOptions now;
      now.every = 1;
      const packmesh::WatchedCells cells = packmesh::watchCells(hemocell, now);
      const FluidStatistics flow = FluidInfo::calculateVelocityStatistics(&hemocell);
      hlog << "(case) iteration " << hemocell.iter << ", " << hemocell.iter * param::dt * 1e3
           << " ms: " << cells.counts[0] << " RBC, " << cells.counts[1] << " PLT; mean velocity "
           << flow.avg * param::dx / param::dt * 1e3 << " mm/s" << std::endl;
      hemocell.writeOutput();
    }
    stop = stopped();
    if (stop || hemocell.iter % tcheckpoint == 0) hemocell.saveCheckPoint();
  }
  hlog << "(case) " << (stop ? "Stopped by a signal, to be continued" : "Finished") << " at iteration "
       << hemocell.iter << std::endl;
  return stop ? 3 : 0;
}
