#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include <cmath>

#include "core/error.hpp"
#include "io/stl.hpp"

namespace porepack::io {

namespace {

void write_poly_data(const Path& path, vtkPolyData* data) {
    write_whole(path, [&](const Path& name) {
        vtkNew<vtkXMLPolyDataWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputData(data);
        writer->SetDataModeToBinary();  // flow_file.cpp says why
        if (writer->Write() != 1 || writer->GetErrorCode() != 0)
            throw MachineError("cannot write " + path.string(), {.fix = "free some disk space or choose another folder with --output"});
    });
}

}  // namespace

void write_vtp(const Path& path, const TriangleSurface& surface) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const auto& p : surface.points) points->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> cells;
    for (const auto& t : surface.triangles) {
        const vtkIdType corners[3] = {t[0], t[1], t[2]};
        cells->InsertNextCell(3, corners);
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    write_poly_data(path, data);
}

void write_vtp(const Path& path, const Paths& paths) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkCellArray> cells;
    vtkNew<vtkDoubleArray> length, tortuosity;
    length->SetName("length_m");
    tortuosity->SetName("tortuosity");
    for (const Line& line : paths.lines) {
        cells->InsertNextCell(static_cast<int>(line.size()));
        for (const auto& p : line) cells->InsertCellPoint(points->InsertNextPoint(p.data()));
        double sum = 0.0;
        for (std::size_t i = 1; i < line.size(); ++i)
            sum += std::hypot(line[i][0] - line[i - 1][0], line[i][1] - line[i - 1][1], line[i][2] - line[i - 1][2]);
        const auto axis = static_cast<std::size_t>(paths.axis);
        const double straight = line.empty() ? 0.0 : std::abs(line.back()[axis] - line.front()[axis]);
        length->InsertNextValue(sum);
        tortuosity->InsertNextValue(straight > 0.0 ? sum / straight : 1.0);
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetLines(cells);
    data->GetCellData()->AddArray(length);
    data->GetCellData()->SetScalars(tortuosity);
    write_poly_data(path, data);
}

}  // namespace porepack::io
